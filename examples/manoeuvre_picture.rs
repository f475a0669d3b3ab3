//! Draws manoeuvres of the bundled vehicle as SVG, seen from above: `cargo run --example manoeuvre_picture -- polyline > docs/polyline.svg`, and
//! `lateral` for the compensation.

#![allow(clippy::print_stdout)] // the picture is what this program is for

use pivot_cal::internals::{
    DEMO_POINTS, DriveStage, Manoeuvre, ManoeuvreMoment, ManoeuvreSettings, PolylinePlan, PolylineSettings, demo_points, replay_manoeuvre,
};
use pivot_cal::verify::{Maps, Metric};
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

const COLOURS: [&str; 5] = ["#1f6fb4", "#d9641e", "#2a8f4f", "#9a3fb0", "#b8860b"];
const WIDTH: f64 = 860.0;

fn main() -> Result<(), Box<dyn Error>> {
    let maps = Maps::read(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/maps")), false)?;
    let settings = ManoeuvreSettings::new()?;
    let which = std::env::args().nth(1).unwrap_or_else(|| "polyline".to_owned());
    let picture = if which == "lateral" { lateral(&maps, &settings)? } else { polyline(&maps, &settings)? };
    println!("{picture}");
    Ok(())
}

/// Every control period of a manoeuvre, and its figures.
fn moments(
    maps: &Maps,
    settings: &ManoeuvreSettings,
    manoeuvre: &Manoeuvre,
) -> Result<(Vec<ManoeuvreMoment>, pivot_cal::internals::Values), Box<dyn Error>> {
    let mut all = Vec::new();
    let values = replay_manoeuvre(maps, settings, manoeuvre, |moment| all.push(*moment))?;
    Ok((all, values))
}

fn header(height: f64) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    )
}

fn text(picture: &mut String, x: f64, y: f64, extra: &str, what: &str) {
    let _ = writeln!(picture, "<text x=\"{x:.1}\" y=\"{y:.1}\" {extra}>{what}</text>");
}

fn line(picture: &mut String, colour: &str, width: f64, points: &[(f64, f64)]) {
    let points: Vec<_> = points.iter().map(|p| format!("{:.1},{:.1}", p.0, p.1)).collect();
    let _ = writeln!(picture, "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" points=\"{}\"/>", points.join(" "));
}

/// The rear axle's middle of the five laws from above, and its lateral error over the way travelled.
fn polyline(maps: &Maps, settings: &ManoeuvreSettings) -> Result<String, Box<dyn Error>> {
    let plan = PolylinePlan::new(&demo_points(), &PolylineSettings::default())?;
    let scale = 52.0;
    let (left, base) = (60.0, 285.0);
    let at = |x_m: f64, y_m: f64| (left + scale * x_m, base - scale * y_m);
    let mut picture = header(760.0);
    text(&mut picture, left, 22.0, "font-weight=\"bold\"", "eight segments from above: plan (grey) and rear axle's middle");
    line(&mut picture, "#bbb", 6.0, &DEMO_POINTS.map(|p| at(p[0], p[1])));
    for (k, segment) in plan.segments.iter().enumerate() {
        let middle = at(0.5 * (segment.from_m[0] + segment.to_m[0]), 0.5 * (segment.from_m[1] + segment.to_m[1]));
        let label = format!("{} {}", k + 1, segment.gear);
        // beside an upright or a steep segment, above a level one
        let (aside, above) = if segment.course_rad.sin().abs() > 0.2 {
            (8.0, if segment.course_rad.cos().abs() < 0.1 { 0.0 } else { 22.0 })
        } else {
            (0.0, -7.0)
        };
        text(&mut picture, middle.0 + aside, middle.1 + above, "fill=\"#555\"", &label);
    }
    let (top, height, right) = (480.0, 220.0, WIDTH - 20.0);
    let mut rows = Vec::new();
    let laws: Vec<Manoeuvre> = Manoeuvre::all().into_iter().filter(|m| m.name.starts_with("polyline-")).collect();
    let (mut longest_s, mut largest_m) = (0.0_f64, 0.0_f64);
    for (manoeuvre, colour) in laws.iter().zip(COLOURS) {
        let (all, values) = moments(maps, settings, manoeuvre)?;
        line(&mut picture, colour, 1.3, &all.iter().step_by(10).map(|m| at(m.state.x_m, m.state.y_m)).collect::<Vec<_>>());
        // one line per leg; means of five periods, a tenth of a second
        let mut errors: Vec<Vec<(f64, f64)>> = vec![Vec::new(); plan.legs.len()];
        let tracked: Vec<&ManoeuvreMoment> = all.iter().filter(|m| m.command.stage == DriveStage::Driving).collect();
        for chunk in tracked.chunks(5).filter(|c| c.iter().all(|m| m.leg == c[0].leg)) {
            let mean = chunk.iter().map(|m| m.command.lateral_error_m).sum::<f64>() / chunk.len() as f64;
            errors[chunk[0].leg].push((chunk[0].state.t_s, mean));
        }
        longest_s = longest_s.max(all.last().map_or(0.0, |m| m.state.t_s));
        largest_m = errors.iter().flatten().fold(largest_m, |m, e| m.max(e.1.abs()));
        let figure = |metric| values.get(metric).map_or("none".to_owned(), |v| format!("{:.0} mm", 1e3 * v));
        let (corner, segment, rms) = (figure(Metric::CornerErrorM), figure(Metric::SegmentErrorM), figure(Metric::SegmentRmsM));
        let name = manoeuvre.name.trim_start_matches("polyline-").to_owned();
        rows.push((format!("{name}: corner {corner}, segment {segment}, RMS {rms}"), colour, errors));
    }
    text(&mut picture, left, top - 10.0, "font-weight=\"bold\"", "lateral error as the controller sees it, means of 0.1 s [mm]");
    let step = if largest_m > 0.1 {
        0.05
    } else if largest_m > 0.04 {
        0.02
    } else {
        0.01
    };
    let limit = (largest_m / step).ceil() * step;
    let plot = |t_s: f64, e_m: f64| (left + t_s / longest_s * (right - left), top + height * 0.5 * (1.0 - e_m / limit));
    let count = (limit / step).round() as i32;
    for k in -count..=count {
        let level = f64::from(k) * step;
        let (y0, shown) = (plot(0.0, level).1, (1e3 * level).round());
        line(&mut picture, "#ddd", 1.0, &[(left, y0), (right, y0)]);
        text(&mut picture, left - 6.0, y0 + 4.0, "text-anchor=\"end\"", &format!("{}", if shown == 0.0 { 0.0 } else { shown }));
    }
    for second in (0..=longest_s as u32).step_by(20) {
        text(&mut picture, plot(f64::from(second), 0.0).0, top + height + 16.0, "text-anchor=\"middle\"", &format!("{second} s"));
    }
    for (k, (label, colour, errors)) in rows.iter().enumerate() {
        for leg in errors {
            line(&mut picture, colour, 1.0, &leg.iter().map(|e| plot(e.0, e.1)).collect::<Vec<_>>());
        }
        text(&mut picture, 470.0, 330.0 + 15.0 * k as f64, &format!("fill=\"{colour}\""), label);
    }
    picture.push_str("</svg>");
    Ok(picture)
}

/// True lateral error and compensation over the way, forward and in reverse.
fn lateral(maps: &Maps, settings: &ManoeuvreSettings) -> Result<String, Box<dyn Error>> {
    let mut picture = header(520.0);
    for (panel, name) in ["lateral-forward", "lateral-reverse"].into_iter().enumerate() {
        let manoeuvre = Manoeuvre::all().into_iter().find(|m| m.name == name).ok_or("no such manoeuvre")?;
        let (all, values) = moments(maps, settings, &manoeuvre)?;
        let (top, height, left, right) = (40.0 + 250.0 * panel as f64, 180.0, 70.0, WIDTH - 60.0);
        let end_m = all.iter().filter_map(|m| m.command.matched).fold(0.0, |end: f64, p| end.max(p.s_m));
        let figure = |metric, factor: f64| values.get(metric).map_or(f64::NAN, |v| factor * v);
        let title = format!(
            "{name}: mean lateral error {:.1} mm before, {:.1} mm after; heading rate × {:.3}",
            figure(Metric::LateralBeforeM, 1e3),
            figure(Metric::LateralAfterM, 1e3),
            figure(Metric::HeadingRateRatio, 1.0)
        );
        text(&mut picture, left, top - 12.0, "font-weight=\"bold\"", &title);
        let x = |s_m: f64| left + s_m / end_m * (right - left);
        let y = |value: f64, limit: f64| top + height * 0.5 * (1.0 - value / limit);
        for k in -3..=3 {
            let place = y(f64::from(k) * 20.0, 60.0);
            line(&mut picture, "#ddd", 1.0, &[(left, place), (right, place)]);
            text(&mut picture, left - 6.0, place + 4.0, &format!("text-anchor=\"end\" fill=\"{}\"", COLOURS[0]), &format!("{} mm", 20 * k));
            text(&mut picture, right + 6.0, place + 4.0, &format!("fill=\"{}\"", COLOURS[1]), &format!("{k}°"));
        }
        let place = |m: &ManoeuvreMoment| m.command.matched.map(|p| p.s_m);
        let errors: Vec<_> = all
            .chunks(5)
            .filter_map(|c| {
                let mean = c.iter().map(|m| m.command.lateral_error_m).sum::<f64>() / c.len() as f64;
                Some((x(place(&c[0])?), y(1e3 * mean, 60.0)))
            })
            .collect();
        let angles: Vec<_> = all.iter().step_by(5).filter_map(|m| Some((x(place(m)?), y(m.compensation_rad.to_degrees(), 3.0)))).collect();
        line(&mut picture, COLOURS[0], 1.0, &errors);
        line(&mut picture, COLOURS[1], 1.6, &angles);
        for way in (0..=end_m as u32).step_by(20) {
            text(&mut picture, x(f64::from(way)), top + height + 16.0, "text-anchor=\"middle\"", &format!("{way} m"));
        }
    }
    text(&mut picture, 70.0, 505.0, &format!("fill=\"{}\"", COLOURS[0]), "lateral error e as the controller sees it, means of 0.1 s");
    text(&mut picture, 400.0, 505.0, &format!("fill=\"{}\"", COLOURS[1]), "compensation added to the tracking law's angle");
    picture.push_str("</svg>");
    Ok(picture)
}
