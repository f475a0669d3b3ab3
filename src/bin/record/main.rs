//! `pivot-cal-record`: the same as `pivot-cal record`.

use std::process::ExitCode;

fn main() -> ExitCode {
    pivot_cal::cli::run_stage("record", std::env::args_os())
}
