//! `pivot-cal-invert`: the same as `pivot-cal invert`.

use std::process::ExitCode;

fn main() -> ExitCode {
    pivot_cal::cli::run_stage("invert", std::env::args_os())
}
