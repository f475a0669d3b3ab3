//! The process boundary: exit status, files written, what is printed where, the same bytes whatever the order and the threads.

#![allow(clippy::unwrap_used)]

#[path = "common/program.rs"]
mod program;

use assert_cmd::Command;
use program::{repo, run, run_with};
use std::path::Path;

/// Two short campaigns on the bundled simulator.
fn logs(folder: &Path) {
    let campaign = std::fs::read_to_string(repo("data/campaigns/torque_steps.toml")).unwrap();
    std::fs::write(folder.join("campaign.toml"), campaign).unwrap();
    let vehicle = repo("data/vehicles/scrubber.toml");
    for (name, seed) in [("a.mcap", "1"), ("b.mcap", "2")] {
        let (status, _, errors) =
            run(folder, &["record", "--vehicle", &vehicle, "--campaign", "campaign.toml", "-o", name, "--seed", seed]);
        assert_eq!(status, 0, "{errors}");
    }
}

#[test]
fn the_chain_runs_with_no_option_and_writes_the_same_bytes_for_any_order_and_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    logs(folder);
    let read = |maps: &str, name: &str| std::fs::read(folder.join(maps).join(name)).unwrap();
    for (threads, maps, order) in [("1", "one", ["a.mcap", "b.mcap"]), ("2", "two", ["b.mcap", "a.mcap"])] {
        let (status, _, errors) = run_with(folder, &[("RAYON_NUM_THREADS", threads)], &["fit", order[0], order[1], "--maps", maps, "-q"]);
        assert_eq!(status, 0, "{errors}");
        let (status, _, errors) = run_with(folder, &[("RAYON_NUM_THREADS", threads)], &["invert", "--maps", maps, "-q"]);
        assert_eq!(status, 0, "{errors}");
    }
    for name in ["table1.csv", "table1.reverse.csv", "table1.json", "fit_traces.json", "table2.csv", "table2.reverse.csv", "table2.json"] {
        assert_eq!(read("one", name), read("two", name), "{name} differs");
    }
    let names = std::fs::read_dir(folder.join("one")).unwrap().count();
    assert_eq!(names, 7, "nothing else is left in the folder");
}

#[test]
fn a_stage_under_its_own_name_is_the_subcommand() {
    let program = |name: &str| Command::cargo_bin(name).unwrap().arg("--help").output().unwrap();
    for stage in ["record", "fit", "invert", "verify"] {
        let alone = program(&format!("pivot-cal-{stage}"));
        assert!(alone.status.success());
        assert!(String::from_utf8_lossy(&alone.stdout).contains("Example"), "{stage} --help has no example");
    }
}

#[test]
fn every_command_has_help_with_an_example() {
    let folder = tempfile::tempdir().unwrap();
    for command in
        ["record", "inspect", "fit", "invert", "verify", "report", "calibrate", "lateral", "check", "export", "diff", "plan", "completions"]
    {
        let (status, help, _) = run(folder.path(), &[command, "--help"]);
        assert_eq!(status, 0);
        assert!(help.contains("Example"), "{command} --help has no example");
    }
}

/// What bash offers for the last of `words`, as its completion calls the script.
fn completed_by_bash(script: &str, words: &[&str]) -> Vec<String> {
    let quoted: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
    let ask = format!(
        "COMP_WORDS=({}); COMP_CWORD={}; _pivot__cal pivot-cal \"${{COMP_WORDS[COMP_CWORD]}}\" \"${{COMP_WORDS[COMP_CWORD-1]}}\"; \
         printf '%s\\n' \"${{COMPREPLY[@]}}\"",
        quoted.join(" "),
        words.len() - 1
    );
    let output = std::process::Command::new("bash").args(["--norc", "-c", &format!("{script}\n{ask}")]).output().unwrap();
    String::from_utf8(output.stdout).unwrap().lines().filter(|line| !line.is_empty()).map(str::to_owned).collect()
}

#[test]
fn bash_completes_commands_options_and_values() {
    let (status, script, _) = run(Path::new("."), &["completions", "bash"]);
    assert_eq!(status, 0);
    let asked = |words: &[&str]| completed_by_bash(&script, words);
    assert_eq!(asked(&["pivot-cal", "calib"]), ["calibrate"]);
    assert_eq!(asked(&["pivot-cal", "fit", "--sig"]), ["--signals"]);
    assert_eq!(asked(&["pivot-cal", "lateral", "fit", "--hel"]), ["--help"]);
    assert_eq!(asked(&["pivot-cal", "export", "--format", "cd"]), ["cdfx"]);
    assert_eq!(asked(&["pivot-cal", "inspect", "--preset", "joi"]), ["joint-state"]);
    assert_eq!(asked(&["pivot-cal", "verify", "--scenario", "parking-s"]), ["parking-shuffle"]);
    for shell in ["zsh", "fish"] {
        let (status, script, _) = run(Path::new("."), &["completions", shell]);
        assert!(status == 0 && script.contains("calibrate") && script.contains("cdfx") && script.contains("parking-shuffle"), "{shell}");
    }
}

#[test]
fn every_command_has_a_manual_page_that_says_what_its_help_says() {
    let folder = tempfile::tempdir().unwrap();
    let (status, _, errors) = run(folder.path(), &["man"]);
    assert_eq!(status, 0, "{errors}");
    let (_, short, _) = run(folder.path(), &["fit", "--help"]);
    let (_, long, _) = run(folder.path(), &["help", "fit"]);
    assert_eq!(short, long);
    let page = std::fs::read_to_string(folder.path().join("man/pivot-cal-fit.1")).unwrap();
    let plain = page.replace('\\', "");
    for option in short.split_whitespace().filter(|word| word.starts_with("--") && word.len() > 3) {
        let option = option.trim_matches(|c: char| !c.is_alphanumeric() && c != '-');
        assert!(plain.contains(option), "{option} is not in the manual page");
    }
    for page in ["pivot-cal.1", "pivot-cal-lateral-fit.1", "pivot-cal-man.1"] {
        assert!(folder.path().join("man").join(page).exists(), "{page}");
    }
}

#[test]
fn an_error_is_a_document_with_json_and_colour_is_asked_for() {
    let (status, document, errors) = run(Path::new("."), &["fit", "nosuch.mcap", "--json"]);
    let document: serde_json::Value = serde_json::from_str(&document).unwrap();
    assert_eq!((status, document["status"].as_i64()), (1, Some(1)));
    assert!(document["error"].as_str().unwrap().contains("nosuch.mcap") && errors.contains("nosuch.mcap"), "{document}");
    let (status, document, _) = run(Path::new("."), &["fit", "--no-such-flag", "--json"]);
    let document: serde_json::Value = serde_json::from_str(&document).unwrap();
    assert!(status == 2 && document["error"].as_str().unwrap().contains("--no-such-flag"), "{document}");
    let (_, _, plain) = run(Path::new("."), &["fit", "nosuch.mcap"]);
    let (_, _, coloured) = run(Path::new("."), &["fit", "nosuch.mcap", "--color", "always"]);
    assert!(!plain.contains('\u{1b}') && coloured.starts_with("\u{1b}["), "{coloured:?}");
}

#[test]
fn json_is_one_document_and_quiet_is_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let log = repo("data/demo.mcap");
    let (status, text, _) = run(folder.path(), &["inspect", &log, "--json"]);
    assert_eq!(status, 0);
    assert!(serde_json::from_str::<serde_json::Value>(&text).unwrap().get("logs").is_some());
    let (status, text, errors) = run(folder.path(), &["inspect", &log, "-q"]);
    assert_eq!((status, text.as_str(), errors.as_str()), (0, "", ""));
}

#[test]
fn inspect_lists_the_runs_of_the_demo_log() {
    let folder = tempfile::tempdir().unwrap();
    let (status, text, errors) = run(folder.path(), &["inspect", &repo("data/demo.mcap"), "--runs", "--json"]);
    assert_eq!(status, 0, "{errors}");
    let document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let runs = document["logs"][0]["runs"]["runs"].as_array().unwrap().len();
    assert!(runs > 60, "{runs} runs");
}

#[test]
fn a_usage_error_is_status_2() {
    let (status, _, errors) = run(Path::new("."), &["fit", "--no-such-flag"]);
    assert_eq!(status, 2);
    assert!(errors.contains("--no-such-flag"));
}
