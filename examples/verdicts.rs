//! Which wrong campaigns, logs, signal maps and command lines a verdict passes.
//!
//! `cargo run --release --example verdicts -- [--kinds "wheelbase;a slope"] [--vehicles scrubber,sweeper,drag] [--skip "resonance;rate limit"] [--seed 1] [--checks]`
//!
//! Every mistake is made to a good campaign of each vehicle, the map is made and judged as `calibrate` does, and compared with the exact map.
//! A map is wrong if, over the cells that it calls measured, the root mean square torque error is above 0.5 N·m (for 44 N·m of torque), or
//! more than 5 % of the errors are above 3 reported standard errors. The goal is no pass of a wrong map.
//!
//! `-- --good N` drives N good campaigns with other seeds instead: the goal is at most 2 of 150 that do not pass, and 5 % with a warning.

#![allow(clippy::print_stdout, clippy::print_stderr)] // a study prints

#[path = "../tests/common/verdicts/suite.rs"]
mod verdicts;

use rayon::prelude::*;
use verdicts::case::Case;
use verdicts::judge::{Outcome, judged};
use verdicts::mistakes::all;
use verdicts::table::{Row, figures, text};
use verdicts::{Fallible, good, vehicles};

fn after(flag: &str, otherwise: &str) -> String {
    let arguments: Vec<String> = std::env::args().collect();
    arguments.iter().position(|a| a == flag).and_then(|k| arguments.get(k + 1)).cloned().unwrap_or_else(|| otherwise.to_owned())
}

fn main() -> Fallible<()> {
    let names = after("--vehicles", &vehicles::NAMES.join(","));
    let vehicles: Vec<&str> = vehicles::NAMES.into_iter().filter(|name| names.split(',').any(|n| n == *name)).collect();
    let seed: u64 = after("--seed", "1").parse()?;
    let good: u64 = after("--good", "0").parse()?;
    if good > 0 {
        return good_campaigns(&vehicles, good);
    }
    let with_checks = std::env::args().any(|a| a == "--checks");
    let (kinds, skipped) = (after("--kinds", ""), after("--skip", ""));
    let is_in = |list: &str, kind: &str| list.split(';').any(|k| k == kind);
    let chosen = |kind: &str| (kinds.is_empty() || is_in(&kinds, kind)) && !is_in(&skipped, kind);
    let cases: Vec<_> = all().into_iter().filter(|m| chosen(m.kind)).flat_map(|m| vehicles.iter().map(move |v| (m, *v))).collect();
    let rows: Vec<Row> = cases
        .into_par_iter()
        .map(|(mistake, vehicle)| {
            let outcome = mistake.made(vehicle, seed).and_then(judged)?;
            eprintln!("{}, {}, {vehicle}: {}", mistake.kind, mistake.strength, figures(&outcome));
            if with_checks {
                eprintln!("  {}", outcome.checks.join("\n  "));
            }
            Ok(Row { mistake, vehicle, outcome })
        })
        .collect::<Fallible<_>>()?;
    print!("{}", text(&rows));
    Ok(())
}

/// Good campaigns: how many do not pass, how many warn.
fn good_campaigns(vehicles: &[&'static str], count: u64) -> Fallible<()> {
    let cases: Vec<_> = (0..count).flat_map(|k| vehicles.iter().map(move |v| (k, *v))).collect();
    let outcomes: Vec<(String, Outcome)> = cases
        .into_par_iter()
        .map(|(k, vehicle)| {
            let (form, case): (&str, Case) = good::driven_form(vehicle, k)?;
            let outcome = judged(case)?;
            let name = format!("{vehicle}, {form}, seed {}", good::seed(k));
            eprintln!("{name}: {}", figures(&outcome));
            Ok((name, outcome))
        })
        .collect::<Fallible<_>>()?;
    let count_of = |of: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|(_, o)| of(o)).count();
    println!("{} good campaigns", outcomes.len());
    println!("- not passed: {}", count_of(&|o| !o.passes()));
    println!("- with a warning: {}", count_of(&|o| !o.warnings.is_empty()));
    println!("- wrong by the limits: {}", count_of(&Outcome::is_wrong));
    for (name, outcome) in outcomes.iter().filter(|(_, o)| !o.passes() || !o.warnings.is_empty() || o.is_wrong()) {
        println!("- {name}: {}", figures(outcome));
    }
    Ok(())
}
