//! `verify --controller`: a process in place of the bundled controller, one that drives and several that break.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::{copied, run, text};
use serde_json::Value;
use std::path::{Path, PathBuf};

const ONE_TURN: [&str; 4] = ["--scenario", "left-90", "--draws", "4"];

/// Drives with a constant torque to 60° and rolls out, or breaks in the way that its argument names.
const CONTROLLER: &str = r#"
use std::io::{BufRead, Write};

fn number(line: &str, key: &str) -> f64 {
    let start = line.find(&format!("\"{key}\":")).map(|at| at + key.len() + 3).unwrap();
    line[start..].split([',', '}']).next().unwrap().parse().unwrap_or(0.0)
}

fn main() {
    let breaks = std::env::args().nth(1).unwrap();
    let (mut phase, mut wheel_deg) = ("idle", 0.0);
    for line in std::io::stdin().lock().lines() {
        let line = line.unwrap();
        if line.contains("\"start\"") {
            continue;
        }
        let is_turning = !line.contains("\"turn\":null");
        let seen_deg = number(&line, "wheel_angle_deg");
        let was = phase;
        phase = match phase {
            "idle" if is_turning => "waiting_for_angle",
            "waiting_for_angle" if seen_deg > 88.5 && line.contains("\"gear\":\"forward\",\"x_m\"") => "driving",
            "driving" if number(&line, "heading_rad") > 1.05 => "waiting_for_standstill",
            "waiting_for_standstill" if number(&line, "speed_mps").abs() < 0.02 => "restoring_angle",
            "restoring_angle" if seen_deg < 1.5 => "succeeded",
            _ => phase,
        };
        wheel_deg = match phase {
            "idle" | "restoring_angle" | "succeeded" => 0.0,
            _ => 90.0,
        };
        if phase == "driving" && was != phase {
            match breaks.as_str() {
                "hangs" => std::thread::sleep(std::time::Duration::from_secs(3600)),
                "nonsense" => println!("hello \u{1b}[2J"),
                "nan" => println!("{{\"torque_nm\": NaN, \"wheel_angle_deg\": 90, \"gear\": \"forward\", \"phase\": \"driving\"}}"),
                "floods" => loop {
                    print!("xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx");
                },
                "dies" => {
                    eprintln!("out of coffee");
                    std::process::exit(7);
                }
                _ => {}
            }
        }
        let torque_nm = if phase == "driving" { 20.0 } else { 0.0 };
        println!("{{\"torque_nm\":{torque_nm},\"wheel_angle_deg\":{wheel_deg},\"gear\":\"forward\",\"phase\":\"{phase}\"}}");
        std::io::stdout().flush().unwrap();
    }
}
"#;

/// The compiled controller, in `folder`.
fn compiled(folder: &Path) -> PathBuf {
    let (source, program) = (folder.join("controller.rs"), folder.join("a controller"));
    std::fs::write(&source, CONTROLLER).unwrap();
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let output = std::process::Command::new(rustc).args(["--edition", "2021", "-A", "warnings", "-o"]).arg(&program).arg(&source).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    program
}

fn verdict(maps: &Path) -> Value {
    serde_json::from_str(&text(maps, "verify.json")).unwrap()
}

#[test]
fn a_process_is_judged_in_place_of_the_bundled_controller_and_its_faults_have_names() {
    let (folder, maps) = copied();
    let program = compiled(folder.path());
    let command = |breaks: &str| format!("'{}' {breaks}", program.display());
    let judge =
        |breaks: &str, more: &[&str]| run(folder.path(), &[&["verify", "--controller", &command(breaks)], &ONE_TURN[..], more].concat());

    let (status, said, errors) = judge("never", &[]);
    assert_eq!(status, 3, "a constant torque keeps no plan: {said}{errors}");
    let found = verdict(&maps);
    assert_eq!(found["controller_command"]["command"], command("never"));
    let scenarios = found["scenarios"].as_array().unwrap();
    assert_eq!((scenarios.len(), &scenarios[0]["draws"]), (1, &4.into()), "nothing is added to the earlier verdict");
    let expected = scenarios[0]["metrics"].as_array().unwrap().iter().find(|m| m["metric"] == "as_expected").unwrap();
    assert_eq!(expected["mean"], 1.0, "every turn ends: {said}");
    assert!(said.contains("controller: the process `") && !said.contains("the controller broke"), "{said}");
    assert_eq!(run(folder.path(), &["report"]).0, 0);
    assert!(text(&maps, "report.html").contains("not about the bundled controller"));
    let (status, _, errors) = run(folder.path(), &["export", "--format", "c"]);
    assert!(status == 3 && errors.contains("the verdict is about the process `"), "{status} {errors}");

    for (breaks, fault) in [
        ("hangs", "no answer within 400 ms"),
        ("nonsense", "it is no answer: expected value at line 1 column 1; the answer was `hello \\u{1b}[2J`"),
        ("nan", "a number is not finite; the answer was `{\"torque_nm\": NaN"),
        ("floods", "an answer is longer than 65536 bytes; it begins with `xxx"),
        ("dies", "it ended (exit status: 7) instead of answering; its last line on standard error: `out of coffee`"),
    ] {
        let (status, said, errors) = judge(breaks, &["--controller-timeout-ms", "400"]);
        assert_eq!(status, 3, "{breaks}: {said}{errors}");
        let reason = verdict(&maps)["reason"].as_str().unwrap().to_owned();
        assert!(
            reason.starts_with("FAIL: left-90: the controller broke: nominal run, at ") && reason.contains(fault),
            "{breaks}: {reason}"
        );
        assert!(reason.contains("; 4 perturbed vehicles were not driven"), "{breaks}: {reason}");
        assert!(said.contains(fault) && said.contains("broke"), "{breaks}: {said}");
    }

    let (status, said, errors) = run(folder.path(), &["verify", "--scenario", "left-30", "--draws", "4"]);
    assert_eq!(status, 0, "the bundled controller inherits no failure: {said}{errors}");
    assert!(verdict(&maps)["controller_command"].is_null() && verdict(&maps)["scenarios"].as_array().unwrap().len() == 1);
}

#[test]
fn a_command_that_cannot_be_judged_is_an_error_and_leaves_the_verdict() {
    let (folder, maps) = copied();
    let before = text(&maps, "verify.json");
    for (flags, fault) in [
        (&["--controller", "no-such-program --fast"][..], "the process `no-such-program --fast` cannot be started"),
        (&["--controller", "'half"], "a quote is not closed"),
        (&["--controller", "x", "--controller-timeout-ms", "0"], "no answer can come within 0 ms"),
        (&["--controller", "x", "--scenario", "parking"], "--controller drives pivots only, and parking is a manoeuvre"),
    ] {
        let (status, _, errors) = run(folder.path(), &[&["verify"], flags].concat());
        assert!(status == 1 && errors.contains(fault), "{status} {errors}");
    }
    assert_eq!(text(&maps, "verify.json"), before);
}
