//! Reading speed, against the limit and against the alternatives.
//!
//! `cargo bench --bench read` makes logs of about 500 MB (signals among images, point clouds and many small topics) in a temporary
//! folder and prints each figure against its goal: six signals read by this library against pure decompression of the same chunks (the
//! limit) and against `mcap::MessageStream`, for each compression and for one and two threads; a log without summary against the same
//! log with one; messages per second of each decoder against its dynamic oracle; positions kept from the last message against a walk
//! over every message; LZ4 frames in place against a streaming decoder; the summary's answer; the peak memory of reading a
//! log of 1 GB and one of 4 GB, each in a process of its own, and how much of it is the requested signals. What is compared is
//! measured in turns, by the clock and by processor time, so that a busy machine disturbs both alike. `PIVOT_CAL_BENCH_MB` changes the size of the logs, `PIVOT_CAL_BENCH_ROUNDS` the number of turns.
#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs)]

#[path = "read/measured.rs"]
mod measured;
#[path = "read/written.rs"]
mod written;

use mcap::Compression;
use mcap::records::{Record, op};
use measured::{in_turns, peak_memory_mb, verdict};
use pivot_cal::internals::{FieldReader, decompress_lz4, read_signals};
use pivot_cal::log::{Depth, Preset, Recording, SignalName, Source, VehicleOverrides, survey};
use rayon::prelude::*;
use std::fs::File;
use std::io::Read as _;
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::time::Instant;
use written::{JOINT_STATE, joint_state, write};

/// Position of each chunk's body and its length.
fn chunks(path: &Path) -> Vec<(u64, usize)> {
    let file = File::open(path).unwrap();
    let length = file.metadata().unwrap().len();
    let (mut at, mut found) = (8, Vec::new());
    let mut head = [0; 9];
    while at + 9 < length {
        file.read_exact_at(&mut head, at).unwrap();
        let size = u64::from_le_bytes(head[1..].try_into().unwrap());
        if head[0] == op::CHUNK {
            found.push((at + 9, size as usize));
        }
        if head[0] == op::FOOTER {
            break;
        }
        at += 9 + size;
    }
    found
}

/// Reads and decompresses every chunk, and nothing else; returns the bytes that came out.
fn decompress(path: &Path, chunks: &[(u64, usize)]) -> u64 {
    let file = File::open(path).unwrap();
    chunks
        .par_iter()
        .map_init(
            || (Vec::new(), Vec::new(), zstd::bulk::Decompressor::new().unwrap()),
            |(raw, out, zstd), (at, length)| {
                raw.resize(*length, 0);
                file.read_exact_at(raw, *at).unwrap();
                let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, raw).unwrap() else { unreachable!() };
                let size = header.uncompressed_size as usize;
                match header.compression.as_str() {
                    "zstd" => {
                        out.clear();
                        out.reserve(size);
                        zstd.decompress_to_buffer(&data, out).unwrap();
                    }
                    "lz4" => {
                        out.resize(size, 0);
                        lz4_flex::frame::FrameDecoder::new(&data[..]).read_exact(out).unwrap();
                    }
                    _ => return size as u64, // reading is all there is to do
                }
                out.len() as u64
            },
        )
        .sum()
}

fn signals(path: &Path) -> u64 {
    recording(path).loss.messages_read
}

fn recording(path: &Path) -> Recording {
    let vehicle = VehicleOverrides { wheelbase_m: Some(0.9), wheel_radius_m: Some(0.12), ..VehicleOverrides::default() };
    let recording = read_signals(path, &Source::Preset(Preset::PivotCal), &vehicle, &|_| {}).unwrap();
    assert!(recording.origins.len() >= 6);
    recording
}

/// `mcap::MessageStream` over the same file, counting the messages of the same topics.
fn message_stream(path: &Path) -> u64 {
    let bytes = std::fs::read(path).unwrap();
    let wanted = ["/joint_states", "/eps/joint_states", "/drive/torque_command", "/drive/torque_feedback", "/imu/twist", "/drive/gear"];
    let stream = mcap::MessageStream::new(&bytes).unwrap();
    stream.map(Result::unwrap).filter(|message| wanted.contains(&message.channel.topic.as_str())).count() as u64
}

/// Messages per second of our plan and of the dynamic decoder over the same payloads; one thread.
fn decoder(name: &str, goal: Option<f64>, reader: &FieldReader, payloads: &[Vec<u8>], mut dynamic: impl FnMut(&[u8])) {
    const ROUNDS: u64 = 100;
    let count = payloads.len() as u64 * ROUNDS;
    let mut ours = || {
        let mut read = 0;
        reader.read_all((0..ROUNDS).flat_map(|_| payloads).map(Vec::as_slice), |values| {
            read += u64::from(std::hint::black_box(values).is_some_and(|values| values.iter().all(Option::is_some)));
        });
        assert_eq!(read, count);
        count
    };
    // fewer of the slow ones, so that both take about as long
    let mut theirs = || {
        for payload in (0..ROUNDS / 10).flat_map(|_| payloads) {
            dynamic(payload);
        }
        count / 10
    };
    let [ours, theirs] = in_turns(rounds(), [&mut ours, &mut theirs]);
    let (ours, theirs) = (count as f64 / ours.best_s() / 1e6, count as f64 / 10.0 / theirs.best_s() / 1e6);
    let goal = goal.map_or_else(String::new, |goal| format!("   goal {goal:.0}: {}", verdict(ours / theirs >= goal)));
    println!("{name:12} {ours:>8.2} {theirs:>8.2} {:>8.1}{goal}", ours / theirs);
}

fn decoders() {
    const COUNT: u64 = 2000; // few enough to stay in the cache: decoding is measured, not memory
    println!("decoder      M msg/s  dynamic    ratio   (the value and its stamp, one thread)");
    let reader = |encoding: &str, schema: Option<(&str, &str, &[u8])>, paths: &[&str]| {
        let paths: Vec<_> = paths.iter().map(|path| path.parse().unwrap()).collect();
        FieldReader::new(encoding, schema, &paths).unwrap()
    };
    let payloads: Vec<_> = (0..COUNT).map(|n| joint_state("base_link", 1_700_000_000_000_000_000 + n, n as f64)).collect();
    let schema = re_ros_msg::MessageSchema::parse("sensor_msgs/msg/JointState", JOINT_STATE).unwrap();
    let specs = schema.dependencies.iter().map(|spec| (spec.name.clone(), spec));
    let resolver = re_ros_msg::deserialize::MapResolver::new(specs);
    let joints = reader(
        "cdr",
        Some(("sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.as_bytes())),
        &[r#"/t.velocity{name=="front_drive_joint"}"#, "/t.header.stamp.sec", "/t.header.stamp.nanosec"],
    );
    decoder("JointState", Some(20.0), &joints, &payloads, |payload| {
        let mut reader = re_cdr::CdrReader::<re_cdr::LittleEndian>::new(&payload[4..]);
        std::hint::black_box(re_ros_msg::deserialize::decode_message(&mut reader, &schema.spec, &resolver).unwrap());
    });
    positions(&joints, &payloads);
    let descriptors: &[u8] = include_bytes!("../fuzz/message.binpb");
    let payloads: Vec<_> = (0..COUNT)
        .map(|n| [&[0x10, 5, 0x1d, 1, 0, 0, 0, 0x22, 3, 1, 2, 3, 0x09][..], &(n as f64).to_le_bytes(), &[0x38, 3, 0x42, 1, b'x']].concat())
        .collect();
    let message = prost_reflect::DescriptorPool::decode(descriptors).unwrap().get_message_by_name("f.M").unwrap();
    let fields = reader("protobuf", Some(("f.M", "protobuf", descriptors)), &["/t.value", "/t.zigzag", "/t.id"]);
    decoder("protobuf", None, &fields, &payloads, |payload| {
        std::hint::black_box(prost_reflect::DynamicMessage::decode(message.clone(), payload).unwrap());
    });
    let text = |n| {
        format!(
            r#"{{"stamp":{{"sec":1700000000,"nsec":{n}}},"wheel":{{"speed_kmh":{n}.5,"angle_rad":-0.1}},"gear":"D","flags":{{"estop":false}}}}"#
        )
    };
    let payloads: Vec<_> = (0..COUNT).map(|n| text(n).into_bytes()).collect();
    let fields = reader("json", None, &["/t.wheel.speed_kmh", "/t.stamp.sec", "/t.stamp.nsec"]);
    decoder("JSON", None, &fields, &payloads, |payload| {
        std::hint::black_box(serde_json::from_slice::<serde_json::Value>(payload).unwrap());
    });
}

/// Smallest gain for which a faster way beside the general one is kept.
const WORTHWHILE: f64 = 1.1;

/// Messages whose strings are as long as in the last message, against those whose strings never are: of these, every one is walked.
fn positions(reader: &FieldReader, payloads: &[Vec<u8>]) {
    let varied: Vec<Vec<u8>> = (0..payloads.len() as u64)
        .map(|n| joint_state(["base_link", "base_link_of_it"][n as usize % 2], 1_700_000_000_000_000_000 + n, n as f64))
        .collect();
    let count = |payloads: &[Vec<u8>]| {
        let mut read = 0;
        reader.read_all((0..100).flat_map(|_| payloads).map(Vec::as_slice), |values| {
            read += u64::from(std::hint::black_box(values).is_some_and(|values| values.iter().all(Option::is_some)));
        });
        read
    };
    let [kept, walked] = in_turns(rounds(), [&mut || count(payloads), &mut || count(&varied)]);
    gain("positions of the last message, against a walk", walked.cpu_over(&kept));
}

/// The frames of a log, decompressed to their buffer and by a streaming decoder.
fn lz4(path: &Path, chunks: &[(u64, usize)]) {
    let file = File::open(path).unwrap();
    let frames: Vec<(Vec<u8>, usize)> = chunks
        .iter()
        .take(100)
        .map(|(at, length)| {
            let mut raw = vec![0; *length];
            file.read_exact_at(&mut raw, *at).unwrap();
            let Record::Chunk { header, data } = mcap::parse_record(op::CHUNK, &raw).unwrap() else { unreachable!() };
            (data.into_owned(), header.uncompressed_size as usize)
        })
        .collect();
    let most = frames.iter().map(|(_, size)| *size).max().unwrap();
    let (mut one, mut other) = (vec![0; most], vec![0; most]);
    let mut in_place = || frames.iter().map(|(data, size)| decompress_lz4(data, &mut one[..*size]).map_or(0, |()| *size as u64)).sum();
    let mut streamed = || {
        let read = |(data, size): &(Vec<u8>, usize)| {
            lz4_flex::frame::FrameDecoder::new(&data[..]).read_exact(&mut other[..*size]).map(|()| *size as u64)
        };
        frames.iter().map(read).map(Result::unwrap).sum()
    };
    assert_eq!(in_place(), streamed());
    let [in_place, streamed] = in_turns(rounds(), [&mut in_place, &mut streamed]);
    gain("LZ4 frames in place, against a stream", streamed.cpu_over(&in_place));
}

fn gain(what: &str, ratio: f64) {
    println!("{what}: {ratio:.2} times as fast by CPU; goal {WORTHWHILE}: {}", verdict(ratio >= WORTHWHILE));
}

fn setting(name: &str, usual: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

fn rounds() -> usize {
    setting("PIVOT_CAL_BENCH_ROUNDS", 7) as usize
}

fn reading(folder: &Path) {
    let megabytes = setting("PIVOT_CAL_BENCH_MB", 500);
    let file = |name: &str, compression, indexed| -> PathBuf {
        let path = folder.join(name);
        write(&path, compression, megabytes, indexed);
        path
    };
    let bare = file("zstd_without_summary.mcap", Some(Compression::Zstd), false);
    println!("logs of {megabytes} MB uncompressed; best of {} turns; MB/s of uncompressed data", rounds());
    println!("ratio: by the clock, best of the turns; CPU: by processor time, median over the turns");
    println!(
        "{:6} {:>7} {:>13} {:>11} {:>6} {:>6} {:>13} {:>6} {:>6}  goal",
        "file", "threads", "decompression", "six signals", "ratio", "CPU", "MessageStream", "ratio", "CPU"
    );
    for (name, compression) in [("zstd", Some(Compression::Zstd)), ("lz4", Some(Compression::Lz4)), ("none", None)] {
        let path = file(&format!("{name}.mcap"), compression, true);
        let chunks = chunks(&path);
        if name == "lz4" {
            lz4(&path, &chunks);
        }
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let size = pool.install(|| decompress(&path, &chunks)) as f64 / 1e6;
            let [limit, ours, stream, unindexed] = in_turns(
                rounds(),
                [
                    &mut || pool.install(|| decompress(&path, &chunks)),
                    &mut || pool.install(|| signals(&path)),
                    &mut || message_stream(&path),
                    &mut || if name == "zstd" { pool.install(|| signals(&bare)) } else { 0 },
                ],
            );
            let of_limit = (limit.best_s() / ours.best_s(), limit.cpu_over(&ours));
            let of_stream = (stream.best_s() / ours.best_s(), stream.cpu_over(&ours));
            let both = |(clock, cpu): (f64, f64), goal: f64| format!("{}, by CPU {}", verdict(clock >= goal), verdict(cpu >= goal));
            let goal = match compression {
                Some(_) => format!("0.85 of decompression: {}", both(of_limit, 0.85)),
                None => format!("2 × MessageStream: {}", both(of_stream, 2.0)),
            };
            println!(
                "{name:6} {threads:>7} {:>13.0} {:>11.0} {:>6.2} {:>6.2} {:>13.0} {:>6.2} {:>6.2}  {goal}",
                size / limit.best_s(),
                size / ours.best_s(),
                of_limit.0,
                of_limit.1,
                size / stream.best_s(),
                of_stream.0,
                of_stream.1,
            );
            if name == "zstd" {
                let ratio = (ours.best_s() / unindexed.best_s(), ours.cpu_over(&unindexed));
                println!(
                    "without summary {threads:>5} thread(s): {:.2} of the same log with one, {:.2} by CPU; goal 0.80: {}",
                    ratio.0,
                    ratio.1,
                    both(ratio, 0.8)
                );
            }
        }
        std::fs::remove_file(&path).unwrap();
    }
}

/// Peak memory of reading a log, and how long its summary takes to answer; each in a process that does nothing else.
fn memory(folder: &Path) {
    let this = std::env::current_exe().unwrap();
    let ask = |path: &Path, what: &str| -> Vec<f64> {
        let output = std::process::Command::new(&this).env(CHILD, format!("{what} {}", path.display())).output().unwrap();
        String::from_utf8(output.stdout).unwrap().split_whitespace().map(|number| number.parse().unwrap()).collect()
    };
    let path = folder.join("large.mcap");
    let mut found = Vec::new();
    for gigabytes in [1, 4] {
        write(&path, Some(Compression::Zstd), gigabytes * 1000, true);
        let answer = ask(&path, "memory");
        let (peak, signals) = (answer[0], answer[1]);
        let answered_s = ask(&path, "summary")[0];
        println!("{gigabytes} GB: summary answered in {:.0} ms; goal 500: {}", answered_s * 1e3, verdict(answered_s < 0.5));
        println!(
            "{gigabytes} GB: peak memory {peak:.1} MB, of which the six signals are {signals:.1} MB; goal below 300 MB: {}",
            verdict(peak < 300.0)
        );
        found.push((peak, peak - signals));
    }
    let growth = |one: f64, four: f64| (format!("{:+.0} %", (four / one - 1.0) * 100.0), verdict((four / one - 1.0).abs() <= 0.2));
    let (whole, rest) = (growth(found[0].0, found[1].0), growth(found[0].1, found[1].1));
    println!("growth from 1 GB to 4 GB: {} in all, {} without the signals; goal within 20 %: {}, {}", whole.0, rest.0, whole.1, rest.1);
}

/// What a process is asked that measures itself: `memory PATH` or `summary PATH`.
const CHILD: &str = "PIVOT_CAL_BENCH_CHILD";

fn child(asked: &str) {
    let (what, path) = asked.split_once(' ').unwrap();
    let path = Path::new(path);
    if what == "memory" {
        let recording = recording(path);
        let values: usize =
            SignalName::ALL.into_iter().filter_map(|name| recording.signals.get(name)).map(pivot_cal::log::Signal::len).sum();
        // a time and a value of eight bytes each
        println!("{} {}", peak_memory_mb().unwrap_or(f64::NAN), values as f64 * 16.0 / f64::from(1 << 20));
    } else {
        let start = Instant::now();
        survey(path, &Source::Preset(Preset::PivotCal), Depth::Summary, &|_| {}).unwrap();
        println!("{}", start.elapsed().as_secs_f64());
    }
}

fn main() {
    if let Ok(asked) = std::env::var(CHILD) {
        return child(&asked);
    }
    let folder = tempfile::tempdir().unwrap();
    decoders();
    reading(folder.path());
    memory(folder.path());
}
