//! `pivot-cal-fit`: the same as `pivot-cal fit`.

use std::process::ExitCode;

fn main() -> ExitCode {
    pivot_cal::cli::run_stage("fit", std::env::args_os())
}
