//! How near the estimator comes to what the data allow, and how far the usual ways stay behind: a Monte Carlo study on synthetic vehicles
//! whose truth is known.
//!
//! `cargo run --release --example study -- [--minutes 5,15,60] [--seeds 4] [--write docs/accuracy.md]`
//!
//! Vehicle A obeys a physics family (inertia, Coulomb, Stribeck, viscous and quadratic friction, drive and brake efficiency); vehicle B adds
//! a bump and a wave that no such family has. Both have 50 ms dead time and 50 ms lag, an encoder at 50 Hz and a yaw rate at 100 Hz. Every
//! method is judged by the torque that it gives for an acceleration, over the covered cells; the usual ways are given the true delays.

#![allow(clippy::print_stdout)] // a study prints

#[path = "../tests/common/study/trial.rs"]
mod trial;

use std::fmt::Write as _;
use trial::{Kind, Outcome};

/// The value after a flag, or its default.
fn after(flag: &str, otherwise: &str) -> String {
    let arguments: Vec<String> = std::env::args().collect();
    arguments.iter().position(|a| a == flag).and_then(|k| arguments.get(k + 1)).cloned().unwrap_or_else(|| otherwise.to_owned())
}

/// Root of the mean square over the trials.
fn pooled(outcomes: &[Outcome], of: impl Fn(&Outcome) -> f64) -> f64 {
    (outcomes.iter().map(|o| of(o).powi(2)).sum::<f64>() / outcomes.len() as f64).sqrt()
}

fn mean(outcomes: &[Outcome], of: impl Fn(&Outcome) -> f64) -> f64 {
    outcomes.iter().map(of).sum::<f64>() / outcomes.len() as f64
}

/// One row of a table of the report.
fn row(minutes: f64, o: &[Outcome]) -> [String; 2] {
    let (ours, bound, floor) = (pooled(o, |o| o.pivot_cal_nm), pooled(o, |o| o.bound_nm), pooled(o, Outcome::floor_nm));
    let (bins, golay, quadratic) = (pooled(o, |o| o.bins_nm), pooled(o, |o| o.savitzky_golay_nm), pooled(o, |o| o.local_quadratic_nm));
    let accuracy = format!(
        "| {minutes} | {} | {:.0} | {bound:.3} | {:.3} | {:.3} | **{ours:.3}** | {:.2} | {:.2} | {quadratic:.3} | {golay:.3} | {bins:.3} |",
        o.len(),
        mean(o, |o| o.cells as f64),
        pooled(o, |o| o.node_exact_nm),
        pooled(o, |o| o.discretisation_nm),
        ours / floor,
        ours / bound,
    );
    let honesty = format!(
        "| {minutes} | {:.1} % | {:.2} | {:.1} | {:.1} | {:.2} |",
        100.0 * mean(o, |o| o.coverage),
        mean(o, |o| o.width_ratio),
        bins / ours,
        quadratic.min(golay) / ours,
        mean(o, |o| o.surface_share),
    );
    [accuracy, honesty]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let minutes: Vec<f64> = after("--minutes", "5,15,60").split(',').map(str::parse).collect::<Result<_, _>>()?;
    let seeds: Vec<u64> = after("--seeds", "4").split(',').map(str::parse).collect::<Result<_, _>>()?;
    let write = after("--write", "");
    let mut report = include_str!("study/introduction.md").to_owned();
    for (kind, title) in [(Kind::Physics, "Vehicle A: physics holds"), (Kind::Wrong, "Vehicle B: physics is wrong")] {
        let mut rows = Vec::new();
        for (k, length) in minutes.iter().enumerate() {
            // one number of seeds for all lengths, or one per length
            let count = seeds[k.min(seeds.len() - 1)];
            let mut outcomes = Vec::new();
            for seed in 1..=count {
                let o = trial::run(kind, *length, seed)?;
                println!("{kind:?}, {length} min, seed {seed}: {o}");
                outcomes.push(o);
            }
            rows.push(row(*length, &outcomes));
        }
        write!(report, "\n## {title}\n\n{}\n", include_str!("study/accuracy_header.md").trim_end())?;
        for [accuracy, _] in &rows {
            writeln!(report, "{accuracy}")?;
        }
        write!(report, "\n{}\n", include_str!("study/honesty_header.md").trim_end())?;
        for [_, honesty] in &rows {
            writeln!(report, "{honesty}")?;
        }
    }
    println!("\n{report}");
    if !write.is_empty() {
        std::fs::write(write, report)?;
    }
    Ok(())
}
