//! Faults around the program: kills, full disks, denied folders, closed pipes, racing writers and readers, a log that is rewritten while it is read.
//!
//! A fault may cost the run; it never leaves a torn file, never hides, and is never taken for a result. `PIVOT_CAL_FAULTS=N` repeats what is
//! random N times; the default is quick.

#![cfg(unix)]
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use assert_cmd::cargo::cargo_bin;
use map_copy::{copied, run};
use pivot_cal::log::{Preset, Source, VehicleOverrides, read};
use pivot_cal::map::{Table2File, sha256_hex};
use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom, Write};
use std::os::unix::fs::{FileTypeExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};

/// Repetitions of what is random.
fn count(default: usize) -> usize {
    std::env::var("PIVOT_CAL_FAULTS").ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn program() -> Command {
    Command::new(cargo_bin("pivot-cal"))
}

fn errors(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!text.contains("fault of pivot-cal") && !text.contains("panicked"), "{text}");
    text
}

/// The files of a folder by name, temporary ones apart.
fn content(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_file());
    let named = entries.map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), std::fs::read(&path).unwrap()));
    named.filter(|(name, _)| !name.starts_with('.')).collect()
}

fn temporary_files(folder: &Path) -> usize {
    std::fs::read_dir(folder).unwrap().filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().starts_with('.')).count()
}

/// The committed map, and the same after `invert --zero-row hold`: two generations of Table 2.
fn two_generations() -> (BTreeMap<String, Vec<u8>>, BTreeMap<String, Vec<u8>>) {
    let (_keep, maps) = copied();
    let old = content(&maps);
    let (status, _, errors) = run(&maps, &["invert", "--maps", ".", "--zero-row", "hold", "-q"]);
    assert_eq!(status, 0, "{errors}");
    let new = content(&maps);
    assert_ne!(old["table2.json"], new["table2.json"]);
    (old, new)
}

#[test]
fn a_kill_before_any_rename_leaves_whole_files_and_a_mixture_is_found() {
    if !cfg!(debug_assertions) {
        return; // the kill is built into the program for tests only
    }
    let (old, new) = two_generations();
    let mut kills = 0;
    for number in 1.. {
        let (_keep, maps) = copied();
        let mut command = program();
        command.current_dir(&maps).env("PIVOT_CAL_KILL_BEFORE_RENAME", number.to_string());
        let output = command.args(["invert", "--maps", ".", "--zero-row", "hold", "-q"]).output().unwrap();
        let left = content(&maps);
        if output.status.success() {
            assert_eq!(left, new);
            break;
        }
        kills += 1;
        for (name, bytes) in &left {
            assert!(old.get(name) == Some(bytes) || new.get(name) == Some(bytes), "{name} is neither the old one nor the new one");
        }
        let is_mixed = left != old;
        let (status, _, errors) = run(&maps, &["export", "--maps", ".", "--format", "json", "-o", "out"]);
        assert_eq!(status, i32::from(is_mixed), "kill {number}: {errors}");
        let (status, findings, _) = run(&maps, &["check", "table2.json"]);
        assert_eq!(status, if is_mixed { 3 } else { 0 }, "kill {number}: {findings}");
        let (status, _, errors) = run(&maps, &["invert", "--maps", ".", "--zero-row", "hold", "-q"]);
        assert_eq!(status, 0, "the next run mends it: {errors}");
        assert_eq!(content(&maps)["table2.json"], new["table2.json"]);
    }
    assert_eq!(kills, 3, "Table 2 is two CSV files and a JSON");
}

#[test]
fn a_fault_of_the_program_asks_for_a_report_and_leaves_the_folder_as_it_was() {
    if !cfg!(debug_assertions) {
        return;
    }
    let (_keep, maps) = copied();
    let old = content(&maps);
    let mut command = program();
    command.current_dir(&maps).env("PIVOT_CAL_KILL_BEFORE_RENAME", "panic");
    let output = command.args(["invert", "--maps", ".", "--zero-row", "hold", "-q"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(101), "{said}");
    for part in ["Please report", "a fault on purpose, at ", "invert --maps . --zero-row hold", env!("CARGO_PKG_VERSION")] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert!(!said.contains("RUST_BACKTRACE") && !said.contains("thread 'main'"), "{said}");
    assert_eq!(content(&maps), old);
    assert_eq!(temporary_files(&maps), 0);
}

#[test]
fn a_disk_that_is_full_costs_the_run_and_changes_nothing() {
    let (_keep, maps) = copied();
    let old = content(&maps);
    // files may have 4 kB; without the signal that would end the process, writing more is an error
    let shell = format!("trap '' XFSZ; ulimit -f 4; exec '{}' invert --maps . --zero-row hold", cargo_bin("pivot-cal").display());
    let output = Command::new("bash").current_dir(&maps).args(["-c", &shell]).output().unwrap();
    let text = errors(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("table2.") && text.matches("File too large").count() == 1 && !text.contains(".pivot-cal-"), "{text}");
    assert_eq!(content(&maps), old);
    assert_eq!(temporary_files(&maps), 0);
}

/// No name can be made in `/sys`, nor below a file, whoever asks.
#[test]
fn a_folder_that_takes_no_file_costs_the_run_and_changes_nothing() {
    let (_keep, maps) = copied();
    let old = content(&maps);
    let demo = map_copy_repo("data/demo.mcap");
    let folders = ["table1.csv", "table1.csv/below", "/sys/kernel"];
    for folder in folders.iter().filter(|folder| !folder.starts_with('/') || Path::new(folder).is_dir()) {
        let commands: [&[&str]; 3] = [
            &["fit", &demo, "--maps", folder, "-q"],
            &["report", "--maps", ".", "-o", &format!("{folder}/page.html")],
            &["export", "--maps", ".", "--format", "json", "-o", folder],
        ];
        for arguments in commands {
            let output = program().current_dir(&maps).args(arguments).output().unwrap();
            let text = errors(&output);
            assert_eq!(output.status.code(), Some(1), "{arguments:?}: {text}");
            assert!(
                text.contains(folder) && text.matches("os error").count() == 1 && !text.contains(".pivot-cal-"),
                "{arguments:?}: {text}"
            );
        }
    }
    assert_eq!(content(&maps), old);
    assert_eq!(temporary_files(&maps), 0);
}

#[test]
fn what_cannot_be_printed_is_an_error_and_a_closed_pipe_is_none() {
    let (_keep, maps) = copied();
    let full = || std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let commands: [&[&str]; 10] = [
        &["--help"],
        &["--version"],
        &["fit", "--help"],
        &["completions", "bash"],
        &["check", "table2.json"],
        &["check", "table2.json", "--json"],
        &["diff", ".", "."],
        &["verify", "--list"],
        &["invert", "--maps", "."],
        &["report", "--maps", "."],
    ];
    for arguments in commands {
        let output = program().current_dir(&maps).args(arguments).stdout(full()).output().unwrap();
        let text = errors(&output);
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {text}");
        assert_eq!(text.matches("standard output").count(), 1, "{arguments:?}: {text}");
        let mut child = program().current_dir(&maps).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut said = String::new();
        child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        assert_eq!((child.wait().unwrap().code(), said.as_str()), (Some(0), ""), "{arguments:?}");
    }
}

#[test]
fn output_goes_where_it_was_sent() {
    let (_keep, maps) = copied();
    let at = |name: &str| maps.join(name);
    let report = |output: &str| run(&maps, &["report", "--maps", ".", "-o", output]);
    assert_eq!(report("page.html").0, 0);
    let page = std::fs::read(at("page.html")).unwrap();
    // a device stays a device
    assert_eq!(report("/dev/null").0, 0);
    assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
    // standard output by any of its names; the summary is not mixed with it
    for name in ["-", "/dev/stdout", "/dev/fd/1"] {
        let (status, printed, said) = report(name);
        assert_eq!(status, 0, "{said}");
        assert!(printed.as_bytes() == page && said.contains("written: "), "{name}");
        let (status, _, said) = run(&maps, &["report", "--maps", ".", "-o", name, "--json"]);
        assert!(status == 1 && said.contains("both print on standard output"), "{said}");
    }
    // a link stays, and what it leads to is replaced
    std::fs::write(at("real.html"), "old").unwrap();
    symlink("real.html", at("link.html")).unwrap();
    assert_eq!(report("link.html").0, 0);
    assert!(std::fs::symlink_metadata(at("link.html")).unwrap().is_symlink() && std::fs::read(at("real.html")).unwrap() == page);
    // a named pipe is written to
    let pipe = at("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read(pipe).unwrap()
    });
    assert_eq!(report("pipe").0, 0);
    assert!(reader.join().unwrap() == page && std::fs::metadata(&pipe).unwrap().file_type().is_fifo());
    // a folder is none of these
    let (status, _, said) = report(".");
    assert!(status == 1 && said.contains("is a folder"), "{said}");
}

#[test]
fn every_command_with_one_product_prints_it_on_a_dash() {
    let (_keep, maps) = without_lateral_table();
    let vehicle = map_copy_repo("data/vehicles/scrubber.toml");
    let campaign = maps.join("campaign.toml");
    std::fs::write(&campaign, "seed = 1\n[[runs]]\ntorque_nm = 20\nhold_s = 1.0\n").unwrap();
    let record = ["record", "--vehicle", &vehicle, "--campaign", "campaign.toml", "-o"];
    let commands: [&[&str]; 4] = [
        &record,
        &["plan", "--maps", ".", "--minutes", "1", "-o"],
        &["diff", "table1.json", "table1.json", "--html"],
        &["export", "--maps", ".", "--format", "rust", "-o"],
    ];
    for arguments in commands {
        let of = |output: &str| program().current_dir(&maps).args(arguments.iter().copied().chain([output])).output().unwrap();
        let printed = of("-");
        assert_eq!(printed.status.code(), Some(0), "{arguments:?}: {}", errors(&printed));
        assert_eq!(of("product").status.code(), Some(0));
        let product = if arguments[0] == "export" { maps.join("product/pivot_map.rs") } else { maps.join("product") };
        assert!(printed.stdout == std::fs::read(&product).unwrap(), "{arguments:?}");
        let _ = std::fs::remove_file(&product).and_then(|()| std::fs::remove_dir(maps.join("product")));
        assert!(!maps.join("-").exists(), "{arguments:?}");
    }
    let (status, _, said) = run(&maps, &["export", "--maps", ".", "--format", "c", "-o", "-"]);
    assert!(status == 1 && said.contains("pivot_map.h, pivot_map.c"), "{said}");
}

/// The maps without the lateral table, whose export would be a second file.
fn without_lateral_table() -> (tempfile::TempDir, PathBuf) {
    let (keep, maps) = copied();
    for file in ["lateral_table.json", "lateral_table.csv"] {
        std::fs::remove_file(maps.join(file)).unwrap();
    }
    (keep, maps)
}

/// A file of the repository.
fn map_copy_repo(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).to_str().unwrap().to_owned()
}

#[test]
fn two_writers_never_mix_their_files() {
    let (old, new) = two_generations();
    let (_keep, maps) = copied();
    for _ in 0..count(4) {
        let start = |row: &str| {
            let mut command = program();
            command.current_dir(&maps).args(["invert", "--maps", ".", "--zero-row", row, "-q"]).stderr(Stdio::piped()).spawn().unwrap()
        };
        let outputs = [start("hold"), start("moving")].map(|child| child.wait_with_output().unwrap());
        assert!(outputs.iter().any(|output| output.status.success()));
        for output in outputs.iter().filter(|output| !output.status.success()) {
            assert!(errors(output).contains("another pivot-cal is writing into this folder"), "{}", errors(output));
        }
        let left = content(&maps);
        assert!(left == old || left == new, "the folder holds files of two runs");
    }
}

#[test]
fn a_reader_sees_the_old_files_or_the_new_ones() {
    let (old, new) = two_generations();
    let (_keep, maps) = without_lateral_table();
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            for k in 0..count(3) {
                let row = if k % 2 == 0 { "hold" } else { "moving" };
                let (status, _, errors) = run(&maps, &["invert", "--maps", ".", "--zero-row", row, "-q"]);
                assert_eq!(status, 0, "{errors}");
            }
            done.store(true, Ordering::Relaxed);
        });
        let mut reads = 0;
        while !done.load(Ordering::Relaxed) || reads < 3 {
            let output = program()
                .current_dir(&maps)
                .args(["export", "--maps", ".", "--format", "rust", "--unverified", "-o", "-"])
                .output()
                .unwrap();
            assert!(output.status.success(), "{}", errors(&output));
            let exported = String::from_utf8(output.stdout).unwrap();
            let sha256 = |files: &BTreeMap<String, Vec<u8>>| {
                Table2File::from_json(std::str::from_utf8(&files["table2.json"]).unwrap()).unwrap().maps[0].csv.sha256.clone()
            };
            let found = exported.split("TABLE2_SHA256: &str = \"").nth(1).unwrap()[..64].to_owned();
            assert!(found == sha256(&old) || found == sha256(&new));
            reads += 1;
        }
    });
}

#[test]
fn a_log_that_is_rewritten_while_it_is_read_never_gives_the_data_of_one_and_the_hash_of_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let one = std::fs::read(map_copy_repo("tests/data/mini_ros2.zstd.mcap")).unwrap();
    // the same log with other bytes in a chunk: a damaged place
    let mut other = one.clone();
    let middle = other.len() / 2;
    other[middle..middle + 64].iter_mut().for_each(|byte| *byte ^= 0x5a);
    let path = folder.path().join("log.mcap");
    let source = Source::Preset(Preset::PivotCal);
    let vehicle =
        VehicleOverrides { wheelbase_m: Some(0.9), wheel_radius_m: Some(0.12), test_angle_deg: Some(90.0), ..VehicleOverrides::default() };
    let read_one = || read(&path, &source, &vehicle, &|_| {});
    let signals_of = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        let recording = read_one().unwrap();
        assert_eq!(recording.source.sha256, sha256_hex(bytes));
        (recording.source.sha256, recording.signals)
    };
    let known = [signals_of(&one), signals_of(&other)];
    assert_ne!(known[0].1, known[1].1, "the damage costs values");
    let done = AtomicBool::new(false);
    let (mut refused, mut whole) = (0, 0);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
            while !done.load(Ordering::Relaxed) {
                for bytes in [&one, &other] {
                    file.seek(SeekFrom::Start(0)).unwrap();
                    file.write_all(bytes).unwrap();
                }
            }
        });
        for _ in 0..count(25) {
            match read_one() {
                Ok(recording) => {
                    let (_, signals) = known.iter().find(|(sha256, _)| *sha256 == recording.source.sha256).unwrap();
                    assert!(*signals == recording.signals, "the hash is that of other data");
                    whole += 1;
                }
                Err(error) => {
                    assert!(error.to_string().contains("changed while it was read"), "{error}");
                    refused += 1;
                }
            }
        }
        done.store(true, Ordering::Relaxed);
    });
    assert_eq!(refused + whole, count(25));
}

/// A log with one message on each of the topics.
fn log_with(path: &Path, topics: &[&str]) {
    let mut writer = mcap::Writer::new(std::io::BufWriter::new(std::fs::File::create(path).unwrap())).unwrap();
    for (number, topic) in topics.iter().enumerate() {
        let channel = writer.add_channel(0, topic, "json", &BTreeMap::new()).unwrap();
        let time = 1_700_000_000_000_000_000 + number as u64;
        let header = mcap::records::MessageHeader { channel_id: channel, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, br#"{"speed\u001b[2J\n":1.0}"#).unwrap();
    }
    writer.finish().unwrap();
}

#[test]
fn names_of_a_log_move_no_cursor_and_break_no_line() {
    let folder = tempfile::tempdir().unwrap();
    let huge = "h".repeat(16 << 20);
    let topics = ["/a\u{1b}[2J", "/b\u{9b}31m", "/c\nverdict: pass", "/d\u{202e}gnp", huge.as_str()];
    let name = "log\u{1b}[31m\nerror: none.mcap";
    log_with(&folder.path().join(name), &topics);
    let is_active = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
    for arguments in [&["inspect", name][..], &["inspect", name, "--json"], &["inspect", name, "--runs"], &["fit", name]] {
        let (_, summary, said) = run(folder.path(), arguments);
        for text in [&summary, &said] {
            assert!(!text.contains(is_active), "{arguments:?}: {text:?}");
            assert!(text.lines().all(|line| !line.starts_with("verdict: pass") && !line.starts_with("error: none")), "{text}");
        }
        assert!(summary.len() + said.len() < 20_000, "{arguments:?}: {} bytes", summary.len() + said.len());
    }
    let (_, summary, _) = run(folder.path(), &["inspect", name]);
    for part in [r"/a\u{1b}[2J", r"/b\u{9b}31m", r"/c\nverdict: pass", r"/d\u{202e}gnp", "(16777216 bytes, crc "] {
        assert!(summary.contains(part), "{part}: {summary}");
    }
}

#[test]
fn errors_say_each_thing_once() {
    let folder = tempfile::tempdir().unwrap();
    let say = |arguments: &[&str]| run(folder.path(), arguments).2;
    let missing = say(&["fit", "missing.mcap"]);
    assert_eq!(missing.matches("No such file").count(), 1, "{missing}");
    let huge = say(&["fit", "missing.mcap", "--dead-time-ms", "1e300"]);
    assert!(huge.contains("1e300") && !huge.contains("00000000"), "{huge}");
    std::fs::write(folder.path().join("blocker"), "").unwrap();
    let vehicle = map_copy_repo("data/vehicles/scrubber.toml");
    std::fs::write(folder.path().join("campaign.toml"), "seed = 1\n[[runs]]\ntorque_nm = 20\nhold_s = 1.0\n").unwrap();
    let blocked = say(&["record", "--vehicle", &vehicle, "--campaign", "campaign.toml", "-o", "blocker/a.mcap"]);
    assert!(blocked.matches("blocker/a.mcap").count() == 1 && !blocked.contains(".pivot-cal-"), "{blocked}");
    let negative = say(&["fit", &map_copy_repo("data/demo.mcap"), "--wheelbase-m", "-1"]);
    assert!(negative.contains("wheelbase_m is -1; allowed"), "{negative}");
}

#[test]
fn old_temporary_files_are_removed_by_the_next_run_and_others_stay() {
    let (_keep, maps) = copied();
    let age = |name: &str, seconds: u64| {
        let file = std::fs::File::create(maps.join(name)).unwrap();
        file.set_modified(std::time::SystemTime::now() - std::time::Duration::from_secs(seconds)).unwrap();
    };
    age(".pivot-cal-Ab3xY9", 86_400);
    age(".pivot-cal-Zz9xY1", 1);
    age(".somebody-else-1", 86_400);
    assert_eq!(run(&maps, &["invert", "--maps", ".", "-q"]).0, 0);
    let left: Vec<PathBuf> = [".pivot-cal-Ab3xY9", ".pivot-cal-Zz9xY1", ".somebody-else-1"].iter().map(|n| maps.join(n)).collect();
    assert_eq!(left.iter().map(|path| path.exists()).collect::<Vec<_>>(), [false, true, true]);
}
