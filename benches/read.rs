//! Reading speed, against the limit and against the alternatives.
//!
//! `cargo bench --bench read` makes logs of about 500 MB (signals among images, point clouds and many small topics) in a temporary
//! folder and prints each figure against its goal: six signals read by this library against pure decompression of the same chunks (the
//! limit) and against `mcap::MessageStream`, for each compression and for one and two threads; a log without summary against the same
//! log with one; messages per second of each decoder against its dynamic oracle; the summary's answer; the peak memory of reading a
//! log of 1 GB and one of 4 GB, each in a process of its own. What is compared is measured in turns, and the best of each counts, so that
//! a busy machine disturbs both alike. `PIVOT_CAL_BENCH_MB` changes the size of the logs, `PIVOT_CAL_BENCH_ROUNDS` the number of turns.
#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs)]

use mcap::records::{MessageHeader, Record, op};
use mcap::{Compression, WriteOptions, Writer};
use pivot_cal::log::{Depth, FieldReader, Preset, Source, VehicleOverrides, read_signals, survey};
use rand::{Rng, RngExt, SeedableRng};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read as _};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

const JOINT_STATE: &str = "\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";
const TWIST: &str = "\
std_msgs/Header header
geometry_msgs/Twist twist
===
MSG: geometry_msgs/Twist
geometry_msgs/Vector3 linear
geometry_msgs/Vector3 angular
===
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

/// A CDR payload in the making.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Self(vec![0, 1, 0, 0])
    }
    fn align(&mut self, size: usize) {
        while !(self.0.len() - 4).is_multiple_of(size) {
            self.0.push(0);
        }
    }
    fn u32(mut self, value: u32) -> Self {
        self.align(4);
        self.0.extend(value.to_le_bytes());
        self
    }
    fn text(self, text: &str) -> Self {
        let mut with = self.u32(text.len() as u32 + 1);
        with.0.extend(text.as_bytes());
        with.0.push(0);
        with
    }
    fn f64(mut self, value: f64) -> Self {
        self.align(8);
        self.0.extend(value.to_le_bytes());
        self
    }
    fn header(self, time: u64) -> Self {
        self.u32((time / 1_000_000_000) as u32).u32((time % 1_000_000_000) as u32).text("base_link")
    }
}

fn joint_state(time: u64, value: f64) -> Vec<u8> {
    let mut message = Cdr::new().header(time).u32(3).text("left_wheel_joint").text("front_drive_joint").text("front_steer_joint");
    for _ in 0..3 {
        message = message.u32(3).f64(f64::NAN).f64(value).f64(value);
    }
    message.0
}

fn twist(time: u64, value: f64) -> Vec<u8> {
    (0..6).fold(Cdr::new().header(time), |message, _| message.f64(value)).0
}

/// A log of about `megabytes`, uncompressed, in chunks of 1 MB: six signals among images, point clouds and forty small topics.
fn write(path: &Path, compression: Option<Compression>, megabytes: u64, indexed: bool) {
    let options = WriteOptions::new()
        .compression(compression)
        .compression_level(1)
        .chunk_size(Some(1 << 20))
        .emit_summary_records(indexed)
        .emit_summary_offsets(indexed)
        .profile("ros2");
    let mut writer = Writer::with_options(BufWriter::new(File::create(path).unwrap()), options).unwrap();
    let mut channel = |topic: &str, name: &str, text: &str| {
        let schema = writer.add_schema(name, "ros2msg", text.as_bytes()).unwrap();
        writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap()
    };
    let joints = channel("/joint_states", "sensor_msgs/msg/JointState", JOINT_STATE);
    let eps = channel("/eps/joint_states", "sensor_msgs/msg/JointState", JOINT_STATE);
    let torque = channel("/drive/torque_command", "std_msgs/msg/Float64", "float64 data\n");
    let feedback = channel("/drive/torque_feedback", "std_msgs/msg/Float64", "float64 data\n");
    let imu = channel("/imu/twist", "geometry_msgs/msg/TwistStamped", TWIST);
    let gear = channel("/drive/gear", "std_msgs/msg/Int8", "int8 data\n");
    let image = channel("/camera/image", "sensor_msgs/msg/Image", "uint8[] data\n");
    let cloud = channel("/lidar/points", "sensor_msgs/msg/PointCloud2", "uint8[] data\n");
    let small: Vec<u16> = (0..40).map(|i| channel(&format!("/node_{i}/status"), "std_msgs/msg/Float64", "float64 data\n")).collect();
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(7);
    // a slope with five bits of noise on it: it compresses to about two thirds, as camera and lidar data do
    let mut noise = vec![0_u8; 300_000];
    random.fill_bytes(&mut noise);
    for (index, byte) in noise.iter_mut().enumerate() {
        *byte = (*byte & 0x1f).wrapping_add((index / 2000) as u8);
    }
    // 32 bytes a point, as drivers lay them out: three coordinates, padding, intensity, ring, padding
    let mut points = Vec::with_capacity(200_000);
    for index in 0..6_250_u32 {
        let angle = f64::from(index) * 1e-3;
        let range = 8.0 + random.random::<f64>();
        for coordinate in [range * angle.cos(), range * angle.sin(), -0.7 + 0.01 * random.random::<f64>()] {
            points.extend((coordinate as f32).to_le_bytes());
        }
        points.extend([0; 4]);
        points.extend(f32::from(random.random_range(0..100_u8)).to_le_bytes());
        points.extend(((index % 32) as u16).to_le_bytes());
        points.extend([0; 10]);
    }
    let mut written = 0;
    let mut number = 0_u64;
    while written < megabytes << 20 {
        let time = 1_700_000_000_000_000_000 + number * 10_000_000;
        let value = (number as f64 * 0.01).sin() + random.random::<f64>() * 1e-3;
        let mut put = |channel_id: u16, payload: &[u8]| {
            let header = MessageHeader { channel_id, sequence: number as u32, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, payload).unwrap();
            written += payload.len() as u64 + 31;
        };
        put(imu, &twist(time, value));
        if number.is_multiple_of(2) {
            put(joints, &joint_state(time, value * 8.0));
            put(eps, &joint_state(time, 1.57));
            put(torque, &Cdr::new().f64(20.0).0);
            put(feedback, &Cdr::new().f64(20.0 + value).0);
        }
        if number.is_multiple_of(10) {
            put(gear, &[0, 1, 0, 0, 1]);
            noise.rotate_left(997);
            put(image, &[&[0, 1, 0, 0][..], &noise].concat());
        }
        if number % 10 == 5 {
            points.rotate_left(32 * 97);
            put(cloud, &[&[0, 1, 0, 0][..], &points].concat());
        }
        for channel in &small {
            put(*channel, &Cdr::new().f64(value).0);
        }
        number += 1;
    }
    writer.finish().unwrap();
}

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
    let vehicle = VehicleOverrides { wheelbase_m: Some(0.9), wheel_radius_m: Some(0.12), ..VehicleOverrides::default() };
    let recording = read_signals(path, &Source::Preset(Preset::PivotCal), &vehicle, &|_| {}).unwrap();
    assert!(recording.origins.len() >= 6);
    recording.loss.messages_read
}

/// `mcap::MessageStream` over the same file, counting the messages of the same topics.
fn message_stream(path: &Path) -> u64 {
    let bytes = std::fs::read(path).unwrap();
    let wanted = ["/joint_states", "/eps/joint_states", "/drive/torque_command", "/drive/torque_feedback", "/imu/twist", "/drive/gear"];
    let stream = mcap::MessageStream::new(&bytes).unwrap();
    stream.map(Result::unwrap).filter(|message| wanted.contains(&message.channel.topic.as_str())).count() as u64
}

/// Each of `works` in turn, `rounds` times over; the best time of each in seconds.
fn in_turns<const N: usize>(rounds: usize, mut works: [&mut dyn FnMut() -> u64; N]) -> [f64; N] {
    let mut best = [f64::INFINITY; N];
    for _ in 0..rounds {
        for (work, best) in works.iter_mut().zip(&mut best) {
            let start = Instant::now();
            std::hint::black_box(work());
            *best = best.min(start.elapsed().as_secs_f64());
        }
    }
    best
}

/// Says whether a figure reaches its goal.
fn verdict(reached: bool) -> &'static str {
    if reached { "reached" } else { "MISSED" }
}

fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
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
    let (ours, theirs) = (count as f64 / ours / 1e6, count as f64 / 10.0 / theirs / 1e6);
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
    let payloads: Vec<_> = (0..COUNT).map(|n| joint_state(1_700_000_000_000_000_000 + n, n as f64)).collect();
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
    println!(
        "{:6} {:>7} {:>13} {:>11} {:>6} {:>13} {:>6}  goal",
        "file", "threads", "decompression", "six signals", "ratio", "MessageStream", "ratio"
    );
    for (name, compression) in [("zstd", Some(Compression::Zstd)), ("lz4", Some(Compression::Lz4)), ("none", None)] {
        let path = file(&format!("{name}.mcap"), compression, true);
        let chunks = chunks(&path);
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
            let goal = match compression {
                Some(_) => format!("0.85 of decompression: {}", verdict(limit / ours >= 0.85)),
                None => format!("2 × MessageStream: {}", verdict(stream / ours >= 2.0)),
            };
            println!(
                "{name:6} {threads:>7} {:>13.0} {:>11.0} {:>6.2} {:>13.0} {:>6.2}  {goal}",
                size / limit,
                size / ours,
                limit / ours,
                size / stream,
                stream / ours
            );
            if name == "zstd" {
                let ratio = ours / unindexed;
                println!(
                    "without summary {threads:>5} thread(s): {ratio:.2} of the same log with one; goal 0.80: {}",
                    verdict(ratio >= 0.8)
                );
            }
        }
        std::fs::remove_file(&path).unwrap();
    }
}

/// Peak memory of reading a log, and how long its summary takes to answer; each in a process that does nothing else.
fn memory(folder: &Path) {
    let this = std::env::current_exe().unwrap();
    let ask = |path: &Path, what: &str| -> f64 {
        let output = std::process::Command::new(&this).env(CHILD, format!("{what} {}", path.display())).output().unwrap();
        String::from_utf8(output.stdout).unwrap().trim().parse().unwrap()
    };
    let path = folder.join("large.mcap");
    let mut peaks = Vec::new();
    for gigabytes in [1, 4] {
        write(&path, Some(Compression::Zstd), gigabytes * 1000, true);
        peaks.push(ask(&path, "memory"));
        let answered_s = ask(&path, "summary");
        println!("{gigabytes} GB: summary answered in {:.0} ms; goal 500: {}", answered_s * 1e3, verdict(answered_s < 0.5));
    }
    let (one, four) = (peaks[0], peaks[1]);
    println!("peak memory: {one:.1} MB on 1 GB, {four:.1} MB on 4 GB; goal below 300 MB: {}", verdict(one.max(four) < 300.0));
    println!(
        "growth from 1 GB to 4 GB: {:.0} %; goal within 20 %: {}",
        (four / one - 1.0) * 100.0,
        verdict((four / one - 1.0).abs() <= 0.2)
    );
}

/// What a process is asked that measures itself: `memory PATH` or `summary PATH`.
const CHILD: &str = "PIVOT_CAL_BENCH_CHILD";

fn child(asked: &str) {
    let (what, path) = asked.split_once(' ').unwrap();
    let path = Path::new(path);
    if what == "memory" {
        signals(path);
        println!("{}", peak_memory_mb().unwrap_or(f64::NAN));
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
