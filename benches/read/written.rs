//! The logs that are read: six signals among images, point clouds and many small topics.

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use rand::{Rng, RngExt, SeedableRng};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

pub(crate) const JOINT_STATE: &str = "\
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

/// A CDR payload that is being written.
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
    fn header(self, frame: &str, time: u64) -> Self {
        self.u32((time / 1_000_000_000) as u32).u32((time % 1_000_000_000) as u32).text(frame)
    }
}

pub(crate) fn joint_state(frame: &str, time: u64, value: f64) -> Vec<u8> {
    let mut message = Cdr::new().header(frame, time).u32(3).text("left_wheel_joint").text("front_drive_joint").text("front_steer_joint");
    for _ in 0..3 {
        message = message.u32(3).f64(f64::NAN).f64(value).f64(value);
    }
    message.0
}

fn twist(time: u64, value: f64) -> Vec<u8> {
    (0..6).fold(Cdr::new().header("base_link", time), |message, _| message.f64(value)).0
}

/// A log of about `megabytes`, uncompressed, in chunks of 1 MB: six signals among images, point clouds and forty small topics.
pub(crate) fn write(path: &Path, compression: Option<Compression>, megabytes: u64, indexed: bool) {
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
            put(joints, &joint_state("base_link", time, value * 8.0));
            put(eps, &joint_state("base_link", time, 1.57));
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
