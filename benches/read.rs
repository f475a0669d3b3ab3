//! Reading speed, against the limit and against the alternatives.
//!
//! `cargo bench --bench read` makes logs of about 500 MB (signals among images, point clouds and many small topics) in a temporary
//! folder and prints, for each compression and for one and two threads: pure decompression of the same chunks (the limit), six signals
//! read by this library, and `mcap::MessageStream`. Then messages per second of each decoder against its dynamic oracle.
//! `PIVOT_CAL_BENCH_MB` changes the size; with `PIVOT_CAL_BENCH_MEMORY` set, the peak memory of reading one such log is printed instead.
#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs)]

use mcap::records::{MessageHeader, Record, op};
use mcap::{Compression, WriteOptions, Writer};
use pivot_cal::log::{FieldReader, Preset, Source, VehicleOverrides, read_signals};
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
            put(cloud, &[&[0, 1, 0, 0][..], &noise[..200_000]].concat());
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

/// Best of three, in seconds.
fn best(mut work: impl FnMut() -> u64) -> f64 {
    (0..3)
        .map(|_| {
            let start = Instant::now();
            std::hint::black_box(work());
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}

/// Messages per second of our plan and of the dynamic decoder over the same payloads; one thread.
fn decoder(name: &str, reader: &FieldReader, payloads: &[Vec<u8>], mut dynamic: impl FnMut(&[u8])) {
    const ROUNDS: u64 = 100;
    let count = payloads.len() as u64 * ROUNDS;
    let ours = best(|| {
        let mut read = 0;
        reader.read_all((0..ROUNDS).flat_map(|_| payloads).map(Vec::as_slice), |values| {
            read += u64::from(std::hint::black_box(values).is_some_and(|values| values.iter().all(Option::is_some)));
        });
        assert_eq!(read, count);
        count
    });
    let theirs = best(|| {
        for payload in (0..ROUNDS).flat_map(|_| payloads) {
            dynamic(payload);
        }
        count
    });
    let rate = |seconds: f64| count as f64 / seconds / 1e6;
    println!("{name:12} {:>8.2} {:>8.2} {:>8.1}", rate(ours), rate(theirs), theirs / ours);
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
    decoder("JointState", &joints, &payloads, |payload| {
        let mut reader = re_cdr::CdrReader::<re_cdr::LittleEndian>::new(&payload[4..]);
        std::hint::black_box(re_ros_msg::deserialize::decode_message(&mut reader, &schema.spec, &resolver).unwrap());
    });
    let descriptors: &[u8] = include_bytes!("../fuzz/message.binpb");
    let payloads: Vec<_> = (0..COUNT)
        .map(|n| [&[0x10, 5, 0x1d, 1, 0, 0, 0, 0x22, 3, 1, 2, 3, 0x09][..], &(n as f64).to_le_bytes(), &[0x38, 3, 0x42, 1, b'x']].concat())
        .collect();
    let message = prost_reflect::DescriptorPool::decode(descriptors).unwrap().get_message_by_name("f.M").unwrap();
    let fields = reader("protobuf", Some(("f.M", "protobuf", descriptors)), &["/t.value", "/t.zigzag", "/t.id"]);
    decoder("protobuf", &fields, &payloads, |payload| {
        std::hint::black_box(prost_reflect::DynamicMessage::decode(message.clone(), payload).unwrap());
    });
    let text = |n| {
        format!(
            r#"{{"stamp":{{"sec":1700000000,"nsec":{n}}},"wheel":{{"speed_kmh":{n}.5,"angle_rad":-0.1}},"gear":"D","flags":{{"estop":false}}}}"#
        )
    };
    let payloads: Vec<_> = (0..COUNT).map(|n| text(n).into_bytes()).collect();
    let fields = reader("json", None, &["/t.wheel.speed_kmh", "/t.stamp.sec", "/t.stamp.nsec"]);
    decoder("JSON", &fields, &payloads, |payload| {
        std::hint::black_box(serde_json::from_slice::<serde_json::Value>(payload).unwrap());
    });
}

fn main() {
    let megabytes = std::env::var("PIVOT_CAL_BENCH_MB").ok().and_then(|text| text.parse().ok()).unwrap_or(500);
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    if std::env::var_os("PIVOT_CAL_BENCH_MEMORY").is_some() {
        let file = path("memory.mcap");
        write(&file, Some(Compression::Zstd), megabytes, true);
        let read = signals(&file);
        println!("{megabytes} MB, {read} messages: peak memory {:.0} MB", peak_memory_mb().unwrap_or(f64::NAN));
        return;
    }
    decoders();
    println!("log of {megabytes} MB uncompressed; best of 3; MB/s of uncompressed data");
    println!("{:22} {:>8} {:>13} {:>13} {:>7} {:>14}", "file", "threads", "decompression", "six signals", "ratio", "MessageStream");
    let mut indexed_s = BTreeMap::new();
    for (name, compression, indexed) in [
        ("zstd", Some(Compression::Zstd), true),
        ("lz4", Some(Compression::Lz4), true),
        ("none", None, true),
        ("zstd, no summary", Some(Compression::Zstd), false),
    ] {
        let file = path(&format!("{}.mcap", name.replace([',', ' '], "_")));
        write(&file, compression, megabytes, indexed);
        let chunks = chunks(&file);
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let size = pool.install(|| decompress(&file, &chunks)) as f64 / 1e6;
            let limit = best(|| pool.install(|| decompress(&file, &chunks)));
            let ours = best(|| pool.install(|| signals(&file)));
            indexed_s.entry((name, threads)).or_insert(ours);
            let stream = if threads == 1 && indexed { format!("{:.0}", size / best(|| message_stream(&file))) } else { String::new() };
            println!("{name:22} {threads:>8} {:>13.0} {:>13.0} {:>7.2} {stream:>14}", size / limit, size / ours, limit / ours);
        }
        std::fs::remove_file(&file).unwrap();
    }
    for threads in [1, 2] {
        let ratio = indexed_s[&("zstd", threads)] / indexed_s[&("zstd, no summary", threads)];
        println!("unindexed, of the indexed file, {threads} thread(s): {ratio:.2}");
    }
}
