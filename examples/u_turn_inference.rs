//! Infers the unpublished dimensions of the published U-turn's vehicle from its known answers: `cargo run --example u_turn_inference`.
//!
//! Unknown are wheelbase, width and overhangs (taken as equal front and rear: the rear one hardly shows), and what "just clears", "just touches"
//! and "between" mean. For each reading the four dimensions that leave the least sum of squares of the four answers in metres are looked for by
//! a pattern search from three starts; the lanes and the curvature that follow are then printed. Finally, other readings of the two lanes are tried.

#![allow(clippy::print_stdout)] // the table is what this program is for

#[path = "u_turn_inference/published.rs"]
mod published;

use pivot_cal::internals::BodyShape;
use pivot_cal::internals::u_turn::{Lane, Method, UTurnSettings, UTurnShape, drive, largest_difference_m};
use published::{Answer, FullLock, Hypothesis, PublishedCase, PublishedFinding, YAW_RATE_RAD_S};
use std::error::Error;

type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> Outcome<()> {
    relation();
    let case = PublishedCase::new()?;
    println!(
        "\n| clears | touches | run-up of | wheelbase | width | overhang | border | inner line | shortest | longest | RMS | 200°/s | 400°/s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let mut best: Option<(f64, BodyShape, Hypothesis)> = None;
    for clears_m in [0.0, 0.3] {
        for touches_m in [0.0, 0.3] {
            for run_up_turn in [(0.7, 400.0), (1.63, 400.0), (1.63, 200.0)] {
                let hypothesis = Hypothesis { clears_m, touches_m, run_up_turn };
                let body = infer(&case, &hypothesis)?;
                let findings = case.findings(body, &hypothesis, &UTurnSettings::default())?;
                let rms = (cost(&findings) / 4.0).sqrt();
                row(&hypothesis, body, &findings, rms);
                if best.is_none_or(|b| rms < b.0) {
                    best = Some((rms, body, hypothesis));
                }
            }
        }
    }
    let Some((rms, body, hypothesis)) = best else { return Ok(()) };
    println!("\nbest: {body:?}\n{hypothesis:?}, RMS {rms:.4} m");
    for finding in case.findings(body, &hypothesis, &UTurnSettings::default())? {
        println!("  {finding:?}");
    }
    for (speed, rate) in [(0.7, 400.0), (3.4, 100.0), (6.0, 200.0), (6.0, 400.0)] {
        let of = |method| PublishedCase::track(body, 11.0, speed, rate, &UTurnSettings { method, ..UTurnSettings::default() });
        let (along, end) = largest_difference_m(&of(Method::Euler)?, &of(Method::RungeKutta)?);
        println!("Euler beside Runge-Kutta at {speed} m/s and {rate}°/s: {along:.4} m along, {end:.4} m at the end");
    }
    others(&case, body)?;
    lanes(&case, body);
    Ok(())
}

/// The answers beside the four lengths: times, the largest speed, and a wheel that does not hold.
fn others(case: &PublishedCase, body: BodyShape) -> Outcome<()> {
    let settings = UTurnSettings::default();
    for rate in [200.0, 400.0] {
        let track = PublishedCase::track(body, 11.0, 6.0, rate, &settings)?;
        let turn_s: f64 = track.phases_s.iter().sum();
        println!(
            "6 m/s, {rate}°/s: the turn takes {turn_s:.2} s, which leaves {:.2} s of 6.18 s; from rest at 3 m/s² 2.00 s are needed",
            6.18 - turn_s
        );
    }
    println!("largest speed that just touches the border, after its own run-up: {:.4} m/s", case.largest_speed_mps(body, 400.0)?);
    for rate in [200.0, 400.0] {
        let turn = FullLock::drive(body, 11.0, 6.0, rate);
        println!(
            "full lock and back without holding, {rate}°/s: turned by {:.1}°, lane {:?}",
            turn.turned_deg,
            turn.bodies.last().and_then(|body| case.lane_of(body))
        );
    }
    let turn = FullLock::drive(body, 11.0, 3.4, 100.0);
    let least_m = turn.bodies.iter().map(|body| case.scene.field.inside_margin_m(body)).fold(f64::INFINITY, f64::min);
    println!("the same at 3.4 m/s, 100°/s: turned by {:.1}°, least distance from the border {least_m:.2} m", turn.turned_deg);
    Ok(())
}

/// Whether any reading lets 6 m/s end nearer with 200°/s than with 400°/s: other wheelbases, the rate at the front wheel instead of the steering
/// wheel, and accelerations in each of the three phases. Dimensions but the wheelbase do not move the track.
fn lanes(case: &PublishedCase, body: BodyShape) {
    println!("\nwidth of the turn at 6 m/s, 200°/s less 400°/s (the published lanes need it below 0):");
    let accels = [-1.5, -0.75, 0.0, 1.5, 3.0];
    for (what, at_front) in [("rate of the steering wheel", false), ("rate of the front wheel", true)] {
        let (mut least, mut tried, mut as_published) = ((f64::INFINITY, String::new()), 0, 0);
        for wheelbase_m in [1.2, 2.1, 3.0, 4.0] {
            let mut car = PublishedCase::car(BodyShape { wheelbase_m, ..body });
            if at_front {
                (car.steering_limit_rad, car.steering_ratio) = (car.wheel_limit_rad(), 1.0);
            }
            let three = accels.into_iter().flat_map(|a| accels.into_iter().flat_map(move |b| accels.into_iter().map(move |c| [a, b, c])));
            for turn_accel_mps2 in three {
                let settings = UTurnSettings { turn_accel_mps2, step_s: 0.02, ..UTurnSettings::default() };
                let track = |deg_s: f64| {
                    drive(&car, &UTurnShape { run_up_m: 11.0, speed_mps: 6.0, steering_rate_rad_s: deg_s.to_radians() }, &settings)
                };
                let (Ok(slow), Ok(fast)) = (track(200.0), track(400.0)) else { continue };
                tried += 1;
                let difference = fast.end().x_m - slow.end().x_m;
                if difference < least.0 {
                    least = (difference, format!("wheelbase {wheelbase_m} m, accelerations {turn_accel_mps2:?} m/s²"));
                }
                let lane = |track| case.scene.lane(track, 0.0).0;
                as_published += usize::from(lane(&slow) == Lane::Number(1) && lane(&fast) == Lane::Number(2));
            }
        }
        println!("  {what}: {tried} turns, least {:+.3} m ({}); lanes as published: {as_published}", least.0, least.1);
    }
}

/// Which law the two pairs of entry speed and curvature follow.
fn relation() {
    // (speed, half of its last digit), (curvature, half of its last digit): 0.21 has two digits, and is not 0.210
    let pairs = [((1.63_f64, 0.005), (0.205_f64, 0.0005)), ((1.585, 0.0005), (0.21, 0.005))];
    println!("law: value at the two pairs, how far apart, how far rounding of the last digits can put them apart");
    for (name, speed_power, curvature_power) in
        [("v κ (yaw rate)", 1.0, 1.0), ("v² κ (lateral acceleration)", 2.0, 1.0), ("v κ² (wheel rate)", 1.0, 2.0)]
    {
        let value = |((v, _), (k, _)): ((f64, f64), (f64, f64))| v.powf(speed_power) * k.powf(curvature_power);
        let (a, b) = (value(pairs[0]), value(pairs[1]));
        let rounding: f64 = pairs.iter().map(|((v, dv), (k, dk))| speed_power * dv / v + curvature_power * dk / k).sum();
        println!("  {name}: {a:.4}, {b:.4}; {:.2} % apart; rounding allows {:.2} %", 100.0 * (a / b - 1.0), 100.0 * rounding);
    }
    println!("  taken: yaw rate {YAW_RATE_RAD_S:.4} rad/s");
}

fn cost(findings: &[PublishedFinding]) -> f64 {
    let metric = |f: &&PublishedFinding| {
        matches!(f.answer, Answer::ClearsBorder | Answer::TouchesInnerLine | Answer::ShortestRunUp | Answer::LongestRunUp)
    };
    findings.iter().filter(metric).map(|f| f.residual_m * f.residual_m).sum()
}

fn body([wheelbase_m, width_m, overhang_m]: [f64; 3]) -> BodyShape {
    BodyShape { wheelbase_m, width_m, front_overhang_m: overhang_m, rear_overhang_m: overhang_m }
}

/// Pattern search (Source: Hooke & Jeeves, 1961) from three starts.
fn infer(case: &PublishedCase, hypothesis: &Hypothesis) -> Outcome<BodyShape> {
    // a coarser step moves the answers by less than a millimetre with the fourth-order method
    let settings = UTurnSettings { step_s: 0.01, method: Method::Euler, ..UTurnSettings::default() };
    let value = |at: [f64; 3]| -> Outcome<f64> {
        let possible = (0.8..4.0).contains(&at[0]) && (0.4..3.0).contains(&at[1]) && (0.0..2.0).contains(&at[2]);
        Ok(if possible { cost(&case.findings(body(at), hypothesis, &settings)?) } else { f64::INFINITY })
    };
    let mut best = (f64::INFINITY, [2.1, 1.6, 0.6]);
    for start in [[2.1, 1.6, 0.6], [1.6, 1.2, 1.0], [2.6, 2.0, 0.2]] {
        let (mut at, mut step) = (start, 0.2);
        let mut here = value(at)?;
        while step > 2e-3 {
            let mut moved = false;
            for axis in 0..3 {
                for sign in [1.0, -1.0] {
                    let mut to = at;
                    to[axis] += sign * step;
                    let there = value(to)?;
                    if there < here {
                        (at, here, moved) = (to, there, true);
                        break;
                    }
                }
            }
            if !moved {
                step *= 0.5;
            }
        }
        if here < best.0 {
            best = (here, at);
        }
    }
    Ok(body(best.1))
}

fn row(hypothesis: &Hypothesis, body: BodyShape, findings: &[PublishedFinding], rms: f64) {
    let of = |answer: Answer| findings.iter().find(|f| f.answer == answer);
    let residual = |answer| of(answer).map_or(f64::NAN, |f| f.residual_m);
    let lane = |answer| of(answer).and_then(|f| f.lane).map_or("none".to_owned(), |l| format!("{l:?}"));
    println!(
        "| {} | {} | {} m/s {}°/s | {:.3} | {:.3} | {:.3} | {:+.3} | {:+.3} | {:+.3} | {:+.3} | {rms:.4} | {} | {} |",
        hypothesis.clears_m,
        hypothesis.touches_m,
        hypothesis.run_up_turn.0,
        hypothesis.run_up_turn.1,
        body.wheelbase_m,
        body.width_m,
        body.front_overhang_m,
        residual(Answer::ClearsBorder),
        residual(Answer::TouchesInnerLine),
        residual(Answer::ShortestRunUp),
        residual(Answer::LongestRunUp),
        lane(Answer::MiddleLane),
        lane(Answer::OuterLane),
    );
}
