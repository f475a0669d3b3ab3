//! One broken thing per test: each ends with its exit status and a message that says what to do.

#![allow(clippy::unwrap_used)]

#[path = "common/program.rs"]
mod program;

use mcap::records::MessageHeader;
use program::{repo, run};
use std::collections::BTreeMap;
use std::path::Path;

/// Runs and returns (exit status, what is wrong): a finding is part of the summary, an error is not.
fn complaint(folder: &Path, args: &[&str]) -> (i32, String) {
    let (status, summary, errors) = run(folder, args);
    (status, if status == 3 { errors + &summary } else { errors })
}

fn expect(folder: &Path, args: &[&str], status: i32, words: &[&str]) {
    let (found, text) = complaint(folder, args);
    for word in words {
        assert!(text.contains(word), "{word:?} is missing in: {text}");
    }
    assert_eq!(found, status, "{text}");
    assert!(!text.contains("panicked"), "{text}");
}

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// A small log of JSON messages on `/drive`, one every 20 ms, from a function of time: (speed, torque, angle in degrees).
fn write_log(path: &Path, wheelbase_m: f64, seconds: f64, signal: impl Fn(f64) -> (f64, f64, f64)) {
    write_log_with(path, wheelbase_m, seconds, signal, |text, _| text);
}

fn write_log_with(
    path: &Path,
    wheelbase_m: f64,
    seconds: f64,
    signal: impl Fn(f64) -> (f64, f64, f64),
    mangle: impl Fn(String, u64) -> String,
) {
    let mut writer = mcap::Writer::new(std::io::BufWriter::new(std::fs::File::create(path).unwrap())).unwrap();
    let text = [("wheelbase_m", wheelbase_m), ("wheel_radius_m", 0.12), ("test_angle_deg", 90.0)];
    let metadata = text.iter().map(|(k, v)| ((*k).to_owned(), v.to_string())).collect::<BTreeMap<_, _>>();
    writer.write_metadata(&mcap::records::Metadata { name: "pivot-cal/vehicle".into(), metadata }).unwrap();
    let channel = writer.add_channel(0, "/drive", "json", &BTreeMap::new()).unwrap();
    for k in 0..(seconds * 50.0) as u64 {
        let (speed, torque, angle) = signal(k as f64 * 0.02);
        let time = 1_700_000_000_000_000_000 + k * 20_000_000;
        let header = MessageHeader { channel_id: channel, sequence: k as u32, log_time: time, publish_time: time };
        let number = |v: f64| if v.is_finite() { v.to_string() } else { "null".to_owned() };
        let message = format!("{{\"speed\":{},\"torque\":{},\"angle\":{}}}", number(speed), number(torque), number(angle));
        writer.write_to_known_channel(&header, mangle(message, k).as_bytes()).unwrap();
    }
    writer.finish().unwrap();
}

const MAP: &str = "[signals]\nspeed = { path = \"/drive.speed\", unit = \"m/s\" }\ntorque = { path = \"/drive.torque\", unit = \"N.m\" }\nangle = { path = \"/drive.angle\", unit = \"deg\" }\n";

/// A sound campaign: steps from rest of 12, 20 and 28 N·m and their coasts, of a vehicle a = 0.03·τ − 0.3 − 0.5·v.
fn campaign(t: f64) -> (f64, f64, f64) {
    steps(t, &[12.0, 20.0, 28.0], 0.03)
}

/// Steps from rest and their coasts, of a vehicle a = gain·τ − 0.3 − 0.5·v.
fn steps(t: f64, torques: &[f64], gain: f64) -> (f64, f64, f64) {
    let (period, run) = (6.0, (t / 6.0) as usize);
    let torque = torques[run % torques.len()];
    let s = t % period;
    let (a0, k) = (gain * torque - 0.3, 0.5);
    let speed = |s: f64| a0 / k * (1.0 - (-k * s).exp());
    let coast = |s: f64| (speed(2.5) + 0.6) * (-k * s).exp() - 0.6;
    let noise = 0.004 * ((t * 7919.0).sin() + (t * 3571.0).cos());
    if s < 1.0 {
        (noise, 0.0, 90.0)
    } else if s < 3.5 {
        (speed(s - 1.0) + noise, torque, 90.0)
    } else {
        (coast(s - 3.5).max(0.0) + noise, 0.0, 90.0)
    }
}

fn sound(folder: &Path, name: &str, wheelbase_m: f64) {
    write_log(&folder.join(name), wheelbase_m, 36.0, campaign);
    std::fs::write(folder.join("signals.toml"), MAP).unwrap();
}

#[test]
fn a_sound_log_fits() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    let (status, text) = complaint(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"]);
    assert_eq!(status, 0, "{text}");
    assert!(folder.path().join("maps/table1.csv").exists() && folder.path().join("maps/table1.json").exists());
}

#[test]
fn a_missing_file_is_named() {
    expect(folder().path(), &["fit", "nowhere.mcap"], 1, &["nowhere.mcap"]);
}

#[test]
fn an_empty_file_is_reported() {
    let folder = folder();
    std::fs::write(folder.path().join("empty.mcap"), b"").unwrap();
    expect(folder.path(), &["fit", "empty.mcap"], 1, &["empty.mcap", "empty"]);
}

#[test]
fn a_file_that_is_no_log_is_reported() {
    let folder = folder();
    std::fs::write(folder.path().join("notes.mcap"), b"these are my notes, not a log").unwrap();
    expect(folder.path(), &["fit", "notes.mcap"], 1, &["notes.mcap", "MCAP"]);
}

#[test]
fn a_topic_that_the_log_does_not_have_is_reported_with_what_it_has() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    std::fs::write(folder.path().join("signals.toml"), MAP.replace("/drive.speed", "/drvie.speed")).unwrap();
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 1, &["/drvie", "/drive"]);
}

#[test]
fn a_field_that_the_messages_do_not_have_is_reported() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    std::fs::write(folder.path().join("signals.toml"), MAP.replace("/drive.speed", "/drive.sped")).unwrap();
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 1, &["sped"]);
}

#[test]
fn a_typo_in_the_signal_map_is_met_with_the_nearest_key() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    std::fs::write(folder.path().join("signals.toml"), MAP.replace("torque =", "torqe =")).unwrap();
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 1, &["signals.toml", "torqe", "torque"]);
}

#[test]
fn a_broken_message_in_the_middle_is_skipped_counted_and_reported() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    let broken = |text: String, k: u64| if k == 700 { text[..9].to_owned() } else { text };
    write_log_with(&folder.path().join("log.mcap"), 0.9, 36.0, campaign, broken);
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 0, &["warning", "1 message(s) of /drive"]);
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml", "--strict"], 3, &["1 message(s) of /drive"]);
}

#[test]
fn values_that_are_no_numbers_are_dropped() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    let holes = |t: f64| if ((t * 50.0).round() as u64).is_multiple_of(97) { (f64::NAN, campaign(t).1, 90.0) } else { campaign(t) };
    write_log(&folder.path().join("log.mcap"), 0.9, 36.0, holes);
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 0, &[]);
}

#[test]
fn time_that_runs_backwards_is_put_in_order() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    let mut writer = mcap::Writer::new(std::io::BufWriter::new(std::fs::File::create(folder.path().join("back.mcap")).unwrap())).unwrap();
    let metadata = [("wheelbase_m", "0.9"), ("wheel_radius_m", "0.12")].map(|(k, v)| (k.to_owned(), v.to_owned())).into();
    writer.write_metadata(&mcap::records::Metadata { name: "pivot-cal/vehicle".into(), metadata }).unwrap();
    let channel = writer.add_channel(0, "/drive", "json", &BTreeMap::new()).unwrap();
    for k in 0..1800u64 {
        // the second half was written before the first
        let k = (k + 900) % 1800;
        let (speed, torque, angle) = campaign(k as f64 * 0.02);
        let time = 1_700_000_000_000_000_000 + k * 20_000_000;
        let header = MessageHeader { channel_id: channel, sequence: k as u32, log_time: time, publish_time: time };
        let text = format!("{{\"speed\":{speed},\"torque\":{torque},\"angle\":{angle}}}");
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    expect(folder.path(), &["fit", "back.mcap", "--signals", "signals.toml", "--maps", "back"], 0, &[]);
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml", "--maps", "straight"], 0, &[]);
    let table = |maps: &str| std::fs::read(folder.path().join(maps).join("table1.csv")).unwrap();
    assert_eq!(table("back"), table("straight"));
}

#[test]
fn logs_of_different_vehicles_are_refused() {
    let folder = folder();
    sound(folder.path(), "a.mcap", 0.9);
    sound(folder.path(), "b.mcap", 1.4);
    expect(
        folder.path(),
        &["fit", "a.mcap", "b.mcap", "--signals", "signals.toml"],
        1,
        &["different vehicles", "wheelbase_m", "0.9", "1.4"],
    );
}

#[test]
fn logs_that_contradict_each_other_give_a_table_that_is_marked() {
    let folder = folder();
    sound(folder.path(), "empty.mcap", 0.9);
    write_log(&folder.path().join("laden.mcap"), 0.9, 36.0, |t| steps(t, &[16.0, 20.0, 28.0], 0.024));
    expect(
        folder.path(),
        &["fit", "empty.mcap", "laden.mcap", "--signals", "signals.toml"],
        3,
        &["contradict", "empty.mcap", "more than laden.mcap", "Fit them apart"],
    );
    assert!(folder.path().join("maps/table1.csv").exists());
}

#[test]
fn runs_at_one_torque_give_a_table_that_is_marked_and_say_which_others_would_help() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    write_log(&folder.path().join("one.mcap"), 0.9, 36.0, |t| steps(t, &[20.0], 0.03));
    expect(folder.path(), &["fit", "one.mcap", "--signals", "signals.toml"], 3, &["hardly varied", "20 and 0 N·m", "12 and 30 N·m"]);
    assert!(folder.path().join("maps/table1.csv").exists());
}

#[test]
fn a_speed_that_changes_four_times_a_second_is_no_speed_signal() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    // repeated at 50 Hz as a slow sensor behind a fast bus is
    write_log(&folder.path().join("slow.mcap"), 0.9, 36.0, |t| {
        let (speed, _, _) = campaign((t * 4.0).floor() / 4.0);
        let (_, torque, angle) = campaign(t);
        (speed, torque, angle)
    });
    expect(
        folder.path(),
        &["fit", "slow.mcap", "--signals", "signals.toml"],
        1,
        &["slow.mcap", "too slow", "times a second", "10 are needed"],
    );
}

#[test]
fn a_coarse_speed_without_dither_gives_the_table_by_intervals() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    write_log(&folder.path().join("coarse.mcap"), 0.9, 72.0, |t| {
        let (s, run) = (t % 6.0, (t / 6.0) as usize);
        let (_, torque, angle) = campaign(t);
        let a0 = 0.03 * [12.0, 20.0, 28.0][run % 3] - 0.3;
        let speed = |s: f64| 2.0 * a0 * (1.0 - (-0.5 * s).exp());
        let true_speed = if s < 1.0 {
            0.0
        } else if s < 3.5 {
            speed(s - 1.0)
        } else {
            ((speed(2.5) + 0.6) * (-0.5 * (s - 3.5)).exp() - 0.6).max(0.0)
        };
        ((true_speed / 0.02).round() * 0.02, torque, angle)
    });
    let (status, text) = complaint(folder.path(), &["fit", "coarse.mcap", "--signals", "signals.toml"]);
    assert_eq!(status, 0, "{text}");
    let json = std::fs::read_to_string(folder.path().join("maps/table1.json")).unwrap();
    assert!(json.contains("each reading counts as an interval"));
    let table = std::fs::read_to_string(folder.path().join("maps/table1.csv")).unwrap();
    let rows: Vec<Vec<f64>> = table.lines().skip(1).map(|l| l.split(',').map(|c| c.parse().unwrap()).collect()).collect();
    let speeds: Vec<f64> = table.lines().next().unwrap().split(',').skip(1).map(|c| c.parse().unwrap()).collect();
    let row = rows.iter().find(|r| (r[0] - 20.0).abs() < 0.1).unwrap();
    for (v, a) in speeds.iter().zip(&row[1..]).filter(|(v, _)| **v > 0.05 && **v < 0.4) {
        let truth = 0.03 * 20.0 - 0.3 - 0.5 * v;
        assert!((a - truth).abs() < 0.05, "at {v} m/s: {a}, the truth is {truth}");
    }
}

#[test]
fn a_log_without_any_torque_step_is_reported() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    write_log(&folder.path().join("idle.mcap"), 0.9, 20.0, |t| (0.001 * (t * 999.0).sin(), 0.0, 90.0));
    expect(folder.path(), &["fit", "idle.mcap", "--signals", "signals.toml"], 1, &["idle.mcap", "no torque step"]);
}

#[test]
fn runs_at_another_angle_are_reported_with_the_angle_that_would_pass() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    write_log(&folder.path().join("log.mcap"), 0.9, 36.0, |t| (campaign(t).0, campaign(t).1, 75.0));
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 1, &["75.0", "90", "2.5", "--test-angle-deg 75"]);
}

#[test]
fn a_log_that_does_not_name_its_vehicle_says_how_to() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    let mut writer = mcap::Writer::new(std::io::BufWriter::new(std::fs::File::create(folder.path().join("bare.mcap")).unwrap())).unwrap();
    let channel = writer.add_channel(0, "/drive", "json", &BTreeMap::new()).unwrap();
    for k in 0..100u64 {
        let time = k * 20_000_000;
        let header = MessageHeader { channel_id: channel, sequence: k as u32, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, b"{\"speed\":0,\"torque\":0,\"angle\":90}").unwrap();
    }
    writer.finish().unwrap();
    expect(folder.path(), &["fit", "bare.mcap", "--signals", "signals.toml"], 1, &["--wheelbase-m"]);
}

#[test]
fn a_table_of_an_unknown_version_is_refused() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 0, &[]);
    let path = folder.path().join("maps/table1.json");
    let text = std::fs::read_to_string(&path).unwrap().replace("\"format_version\": 1", "\"format_version\": 99");
    std::fs::write(&path, text).unwrap();
    expect(folder.path(), &["invert"], 1, &["table1.json", "version 99", "version 1"]);
}

#[test]
fn a_table_edited_by_hand_is_found_out() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    expect(folder.path(), &["fit", "log.mcap", "--signals", "signals.toml"], 0, &[]);
    expect(folder.path(), &["invert"], 0, &[]);
    let path = folder.path().join("maps/table2.csv");
    let text = std::fs::read_to_string(&path).unwrap();
    let line = text.lines().nth(3).unwrap();
    let edited = text.replace(line, &format!("{line}1"));
    std::fs::write(&path, edited).unwrap();
    let scenario = ["verify", "--scenario", "left-90", "--draws", "4"];
    expect(folder.path(), &scenario, 1, &["table2.csv", "--force"]);
    let (status, _, errors) = run(folder.path(), &[&scenario[..], &["--force"]].concat());
    assert!([0, 3].contains(&status) && errors.contains("table2.csv"), "{errors}");
}

#[test]
fn inverting_before_fitting_says_what_to_do() {
    expect(folder().path(), &["invert"], 1, &["table1.json", "pivot-cal fit"]);
}

#[test]
fn a_wrong_break_is_a_usage_error() {
    expect(folder().path(), &["invert", "--speed-breaks", "0:0:1"], 2, &["start:step:stop"]);
    expect(folder().path(), &["fit"], 2, &["LOG"]);
}

#[test]
fn nothing_is_left_behind_by_a_command_that_fails() {
    let folder = folder();
    sound(folder.path(), "log.mcap", 0.9);
    write_log(&folder.path().join("idle.mcap"), 0.9, 20.0, |_| (0.0, 0.0, 90.0));
    expect(folder.path(), &["fit", "idle.mcap", "--signals", "signals.toml"], 1, &[]);
    assert!(!folder.path().join("maps").exists());
    assert!(Path::new(&repo("data/demo.mcap")).exists());
}
