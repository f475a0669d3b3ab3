//! `pivot-cal-verify`: the same as `pivot-cal verify`.

use std::process::ExitCode;

fn main() -> ExitCode {
    pivot_cal::cli::run_stage("verify", std::env::args_os())
}
