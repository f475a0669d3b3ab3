//! Draws one pivot of the bundled vehicle as SVG: `cargo run --example pivot_picture > docs/pivot.svg`.

#![allow(clippy::print_stdout)] // the picture is what this program is for

use pivot_cal::internals::{PhysicalSettings, PivotMoment, WorldSettings as World, known_maps, replay};
use pivot_cal::map::Vehicle;
use pivot_cal::verify::{Maps, Scenario, VerifySettings};
use std::error::Error;
use std::fmt::Write as _;

/// Size of the picture and of one panel [px].
const WIDTH: f64 = 860.0;
const PANEL: f64 = 150.0;
const LEFT: f64 = 70.0;
const RIGHT: f64 = 20.0;
const GAP: f64 = 34.0;

/// A line of a panel: its name, its colour, its points (time [s], value).
struct Line {
    name: &'static str,
    colour: &'static str,
    points: Vec<(f64, f64)>,
}

struct Panel {
    title: &'static str,
    lines: Vec<Line>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let vehicle =
        Vehicle { wheelbase_m: 0.92, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: Some(44.0), torque_full_scale_nm: None };
    let (table1, table2) = known_maps(&World::physical(vehicle, PhysicalSettings::default()))?;
    let maps = Maps::new(table1, table2)?;
    let scenario = Scenario::all().into_iter().find(|s| s.name == "left-90").ok_or("no such scenario")?;
    let mut moments = Vec::new();
    replay(&maps, &VerifySettings::new()?, &scenario, |moment| moments.push(*moment))?;
    println!("{}", svg(&panels(&moments)));
    Ok(())
}

fn panels(moments: &[PivotMoment]) -> Vec<Panel> {
    let line = |name, colour, value: &dyn Fn(&PivotMoment) -> Option<f64>| Line {
        name,
        colour,
        points: moments.iter().filter_map(|m| Some((m.state.t_s, value(m)?))).collect(),
    };
    let (blue, orange) = ("#1f6fb4", "#d9641e");
    vec![
        Panel {
            title: "front-wheel speed [m/s]",
            lines: vec![
                line("asked for", orange, &|m| m.command.drive.map(|d| d.target_speed_mps)),
                line("true", blue, &|m| Some(m.state.speed_mps)),
            ],
        },
        Panel {
            title: "acceleration [m/s²]",
            lines: vec![
                line("desired", orange, &|m| m.command.drive.map(|d| d.accel_mps2)),
                line("true", blue, &|m| Some(m.state.accel_mps2)),
            ],
        },
        Panel {
            title: "torque [N·m]",
            lines: vec![line("commanded", orange, &|m| Some(m.command.torque_nm)), line("effective", blue, &|m| Some(m.state.torque_nm))],
        },
        Panel {
            title: "angle [°]",
            lines: vec![
                line("front wheel", orange, &|m| Some(m.state.wheel_angle_rad.to_degrees())),
                line("heading", blue, &|m| Some(m.state.heading_rad.to_degrees())),
            ],
        },
    ]
}

fn svg(panels: &[Panel]) -> String {
    let height = GAP + panels.len() as f64 * (PANEL + GAP) + 16.0;
    let end_s = panels.iter().flat_map(|p| &p.lines).flat_map(|l| &l.points).fold(0.0, |end: f64, p| end.max(p.0));
    let x = |t_s: f64| LEFT + t_s / end_s * (WIDTH - LEFT - RIGHT);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"12\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (k, panel) in panels.iter().enumerate() {
        let top = GAP + k as f64 * (PANEL + GAP);
        let values = || panel.lines.iter().flat_map(|l| &l.points).map(|p| p.1);
        let step = tick(values().fold(0.0, f64::max) - values().fold(0.0, f64::min));
        let low = (values().fold(0.0, f64::min) / step).floor() * step;
        let high = (values().fold(0.0, f64::max) / step).ceil() * step;
        let y = |value: f64| top + PANEL * (high - value) / (high - low);
        let mut level = low;
        while level <= high + 0.5 * step {
            let shown = if level.abs() < 1e-9 { 0.0 } else { (level * 1e6).round() / 1e6 };
            let (right, place, base) = (WIDTH - RIGHT, y(level), y(level) + 4.0);
            let _ = writeln!(text, "<line x1=\"{LEFT}\" x2=\"{right}\" y1=\"{place:.1}\" y2=\"{place:.1}\" stroke=\"#ddd\"/>");
            let _ = writeln!(text, "<text x=\"{}\" y=\"{base:.1}\" text-anchor=\"end\">{shown}</text>", LEFT - 6.0);
            level += step;
        }
        let _ = writeln!(text, "<text x=\"{LEFT}\" y=\"{}\" font-weight=\"bold\">{}</text>", top - 8.0, panel.title);
        for (n, line) in panel.lines.iter().enumerate() {
            let points: Vec<_> = line.points.iter().map(|&(t, v)| format!("{:.1},{:.1}", x(t), y(v))).collect();
            let _ =
                writeln!(text, "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" points=\"{}\"/>", line.colour, points.join(" "));
            let place = WIDTH - RIGHT - 180.0 + 100.0 * n as f64;
            let _ = writeln!(text, "<text x=\"{place}\" y=\"{}\" fill=\"{}\">{}</text>", top - 8.0, line.colour, line.name);
        }
    }
    for second in 0..=end_s as u32 {
        let place = x(f64::from(second));
        let _ = writeln!(text, "<text x=\"{place:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{second} s</text>", height - 24.0);
    }
    text.push_str("</svg>");
    text
}

/// A round step that divides `span` into three to seven pieces.
fn tick(span: f64) -> f64 {
    let power = 10_f64.powf((span / 5.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| span / step <= 6.0).unwrap_or(power)
}
