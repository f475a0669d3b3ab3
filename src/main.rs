//! `pivot-cal`: every command under one name.

use std::process::ExitCode;

fn main() -> ExitCode {
    pivot_cal::cli::run(std::env::args_os())
}
