//! What a controller of the user's costs per control period beyond the bundled one, as a shared library and as a process:
//! `cargo run --release --example controller_overhead`. It needs a C compiler `cc`; the map is that of `maps/`.
//!
//! The library is the exported law itself, so that what it costs more than the bundled law is the call. The process answers every line with the same
//! one, so that what it costs is the protocol: two lines of JSON, two pipes.

#![allow(clippy::print_stdout)] // the figures are what this program is for

use pivot_cal::export::{ExportSettings, Format, MapSource};
use pivot_cal::internals::replay;
use pivot_cal::verify::{ControllerCommand, Maps, Scenario, VerifySettings, verify};
use std::error::Error;
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Answers every line but the first with the same one: it waits for the wheel for ever, so that the turn ends after 120 s of the vehicle's time.
const ECHO: &str = r#"
#include <stdio.h>
#include <string.h>
static char line[65536];
int main(void)
{
    while (fgets(line, sizeof line, stdin) != NULL) {
        if (strstr(line, "\"start\"") == NULL) {
            fputs(strstr(line, "\"turn\":null") == NULL
                      ? "{\"torque_nm\":0.0,\"wheel_angle_deg\":0.0,\"gear\":\"neutral\",\"phase\":\"waiting_for_angle\"}\n"
                      : "{\"torque_nm\":0.0,\"wheel_angle_deg\":0.0,\"gear\":\"neutral\",\"phase\":\"idle\"}\n",
                  stdout);
            fflush(stdout);
        }
    }
    return 0;
}
"#;

/// Runs of which the fastest counts.
const RUNS: usize = 15;

fn compile(folder: &Path, arguments: &[&str]) -> Result<(), Box<dyn Error>> {
    let status = Command::new("cc").current_dir(folder).args(["-std=c99", "-O2", "-ffp-contract=off"]).args(arguments).status()?;
    if status.success() { Ok(()) } else { Err("cc failed".into()) }
}

/// Fastest time of a verdict on one scenario, nominal, without what a verdict on none takes [s].
fn seconds(maps: &Maps, settings: &VerifySettings) -> Result<f64, Box<dyn Error>> {
    let none = VerifySettings { scenarios: Vec::new(), ..settings.clone() };
    let fastest = |settings: &VerifySettings| -> Result<f64, Box<dyn Error>> {
        let mut least_s = f64::INFINITY;
        for _ in 0..RUNS {
            let begun = Instant::now();
            verify(maps, settings)?;
            least_s = least_s.min(begun.elapsed().as_secs_f64());
        }
        Ok(least_s)
    };
    Ok(fastest(settings)? - fastest(&none)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let source = MapSource::read(Path::new("maps"))?;
    for file in Format::ControllerC.files(&source, &ExportSettings::default())? {
        std::fs::write(folder.path().join(&file.name), file.content())?;
    }
    std::fs::write(folder.path().join("echo.c"), ECHO)?;
    compile(folder.path(), &["-fPIC", "-shared", "-o", "law.so", "pivot_controller.c", "pivot_controller_library.c", "-lm"])?;
    compile(folder.path(), &["-o", "echo", "echo.c"])?;

    let maps = Maps::read(Path::new("maps"), false)?;
    let scenarios: Vec<Scenario> = Scenario::all().into_iter().filter(|s| s.name == "chained").collect();
    let settings = VerifySettings { scenarios, draws: 0, comparison_draws: 0, ..VerifySettings::new()? };
    let mut periods = 0_u32;
    replay(&maps, &settings, &settings.scenarios[0], |_| periods += 1)?;
    let bundled_us = 1e6 * seconds(&maps, &settings)? / f64::from(periods);
    let with = |name: &str| -> Result<VerifySettings, Box<dyn Error>> {
        let command = ControllerCommand::new(&folder.path().join(name).display().to_string(), 1000)?;
        Ok(VerifySettings { controller_command: Some(command), ..settings.clone() })
    };
    let library_us = 1e6 * seconds(&maps, &with("law.so")?)? / f64::from(periods);
    // 5 periods before the turn, 120 s of 0.02 s in it, and 2.5 s after its end
    let process_us = 1e6 * seconds(&maps, &with("echo")?)? / (5.0 + 6000.0 + 125.0);
    println!("bundled law: {bundled_us:.2} µs per control period, the simulated vehicle included ({periods} periods)");
    println!("library:     {library_us:.2} µs, {:.2} µs more", library_us - bundled_us);
    println!("process:     {process_us:.2} µs, {:.2} µs more", process_us - bundled_us);
    Ok(())
}
