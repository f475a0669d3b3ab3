//! The messages of a recorded log, to be changed as somebody's log was, and written as a log again.
//!
//! In and out: the bytes of an MCAP file of `record`. The values that matter lie at fixed places of the messages.

use mcap::records::{MessageHeader, Metadata};
use std::collections::BTreeMap;
use std::io::Cursor;

/// Topics of a recorded log, by what they hold.
pub(crate) const COMMAND: &str = "/drive/torque_command";
pub(crate) const FEEDBACK: &str = "/drive/torque_feedback";
pub(crate) const SPEED: &str = "/joint_states";
pub(crate) const ANGLE: &str = "/eps/joint_states";
pub(crate) const YAW_RATE: &str = "/imu/twist";
pub(crate) const GEAR: &str = "/drive/gear";

/// One message.
#[derive(Debug, Clone)]
pub(crate) struct LogMessage {
    /// Its topic.
    pub(crate) topic: String,
    /// Time at which it was logged [ns].
    pub(crate) log_ns: u64,
    /// Time at which it was published [ns]: the stamp of a message without a header.
    pub(crate) publish_ns: u64,
    data: Vec<u8>,
}

/// A log in memory.
#[derive(Debug, Clone)]
pub(crate) struct Log {
    /// The messages, in the order of the log.
    pub(crate) messages: Vec<LogMessage>,
    /// Name, encoding and text of each topic's schema.
    schemas: BTreeMap<String, (String, String, Vec<u8>)>,
    metadata: Vec<Metadata>,
}

impl LogMessage {
    fn has_header(&self) -> bool {
        [SPEED, ANGLE, YAW_RATE, "/odom"].contains(&self.topic.as_str())
    }

    /// Its number: N·m, rad/s of the wheel, rad, rad/s of the vehicle.
    pub(crate) fn value(&self) -> Option<f64> {
        let at = self.place()?;
        Some(f64::from_le_bytes(self.data.get(at..at + 8)?.try_into().ok()?))
    }

    /// Replaces its number.
    pub(crate) fn set_value(&mut self, value: f64) {
        if let Some(at) = self.place() {
            self.data[at..at + 8].copy_from_slice(&value.to_le_bytes());
        }
    }

    fn place(&self) -> Option<usize> {
        let from_end = match self.topic.as_str() {
            COMMAND | FEEDBACK => return Some(4),
            SPEED => 20,
            ANGLE => 16,
            YAW_RATE => 8,
            _ => return None,
        };
        self.data.len().checked_sub(from_end)
    }

    /// Its stamp [ns]: that of the header, otherwise the publish time.
    pub(crate) fn stamp_ns(&self) -> u64 {
        if !self.has_header() {
            return self.publish_ns;
        }
        let word = |at: usize| u64::from(u32::from_le_bytes([self.data[at], self.data[at + 1], self.data[at + 2], self.data[at + 3]]));
        word(4) * 1_000_000_000 + word(8)
    }

    /// Replaces its stamp.
    pub(crate) fn set_stamp_ns(&mut self, ns: u64) {
        if self.has_header() {
            self.data[4..8].copy_from_slice(&((ns / 1_000_000_000) as u32).to_le_bytes());
            self.data[8..12].copy_from_slice(&((ns % 1_000_000_000) as u32).to_le_bytes());
        } else {
            self.publish_ns = ns;
        }
    }
}

impl Log {
    /// Reads the bytes of a log.
    ///
    /// # Errors
    /// No MCAP file.
    pub(crate) fn read(bytes: &[u8]) -> mcap::McapResult<Self> {
        let mut log = Self { messages: Vec::new(), schemas: BTreeMap::new(), metadata: Vec::new() };
        for message in mcap::MessageStream::new(bytes)? {
            let message = message?;
            let topic = message.channel.topic.clone();
            if let (false, Some(schema)) = (log.schemas.contains_key(&topic), &message.channel.schema) {
                log.schemas.insert(topic.clone(), (schema.name.clone(), schema.encoding.clone(), schema.data.to_vec()));
            }
            let (log_ns, publish_ns) = (message.log_time, message.publish_time);
            log.messages.push(LogMessage { topic, log_ns, publish_ns, data: message.data.to_vec() });
        }
        if let Some(summary) = mcap::Summary::read(bytes)? {
            for index in &summary.metadata_indexes {
                log.metadata.push(mcap::read::metadata(bytes, index)?);
            }
        }
        Ok(log)
    }

    /// The bytes of the log, messages in the order of their log times.
    ///
    /// # Errors
    /// Any error of the MCAP writer.
    pub(crate) fn write(mut self) -> mcap::McapResult<Vec<u8>> {
        self.messages.sort_by_key(|m| m.log_ns);
        let options = mcap::WriteOptions::new().profile("ros2").compression(None);
        let mut writer = options.create(Cursor::new(Vec::new()))?;
        for metadata in &self.metadata {
            writer.write_metadata(metadata)?;
        }
        let mut channels = BTreeMap::new();
        for (topic, (name, encoding, text)) in &self.schemas {
            let schema = writer.add_schema(name, encoding, text)?;
            channels.insert(topic.as_str(), writer.add_channel(schema, topic, "cdr", &BTreeMap::new())?);
        }
        for (k, message) in self.messages.iter().enumerate() {
            let Some(&channel_id) = channels.get(message.topic.as_str()) else { continue };
            let header = MessageHeader { channel_id, sequence: k as u32, log_time: message.log_ns, publish_time: message.publish_ns };
            writer.write_to_known_channel(&header, &message.data)?;
        }
        writer.finish()?;
        Ok(writer.into_inner().into_inner())
    }

    /// First log time [ns].
    fn start_ns(&self) -> u64 {
        self.messages.iter().map(|m| m.log_ns).min().unwrap_or(0)
    }

    /// Length [s].
    pub(crate) fn length_s(&self) -> f64 {
        let end_ns = self.messages.iter().map(|m| m.log_ns).max().unwrap_or(0);
        (end_ns - self.start_ns()) as f64 * 1e-9
    }

    /// Changes every message of a topic; the function gets the time since the log's start [s] and the message.
    pub(crate) fn change(&mut self, topic: &str, mut change: impl FnMut(f64, &mut LogMessage)) {
        let start_ns = self.start_ns();
        for message in self.messages.iter_mut().filter(|m| m.topic == topic) {
            change((message.log_ns - start_ns) as f64 * 1e-9, message);
        }
    }

    /// Changes the values of a topic; the function gets the time since the log's start [s] and the value.
    pub(crate) fn values(&mut self, topic: &str, mut change: impl FnMut(f64, f64) -> f64) {
        self.change(topic, |t_s, message| {
            if let Some(value) = message.value() {
                message.set_value(change(t_s, value));
            }
        });
    }

    /// Changes the stamps of a topic by the function of the time since the log's start [s].
    pub(crate) fn stamps(&mut self, topic: &str, mut ahead_s: impl FnMut(f64) -> f64) {
        self.change(topic, |t_s, message| {
            let ns = message.stamp_ns().saturating_add_signed((ahead_s(t_s) * 1e9) as i64);
            message.set_stamp_ns(ns);
        });
    }

    /// Keeps the messages of a topic for which the function of the time since the log's start [s] is true.
    pub(crate) fn keep(&mut self, topic: &str, mut keep: impl FnMut(f64) -> bool) {
        let start_ns = self.start_ns();
        self.messages.retain(|m| m.topic != topic || keep((m.log_ns - start_ns) as f64 * 1e-9));
    }

    /// The values of a topic over log time: time since the log's start [s], value.
    pub(crate) fn series(&self, topic: &str) -> Vec<(f64, f64)> {
        let start_ns = self.start_ns();
        let of_topic = self.messages.iter().filter(|m| m.topic == topic);
        of_topic.filter_map(|m| Some(((m.log_ns - start_ns) as f64 * 1e-9, m.value()?))).collect()
    }

    /// Time of the first reverse gear since the log's start [s]; infinite without one.
    pub(crate) fn reverse_from_s(&self) -> f64 {
        let start_ns = self.start_ns();
        // the gear is the byte behind the encapsulation: 2 is reverse
        let reverse = self.messages.iter().filter(|m| m.topic == GEAR && m.data.get(4) == Some(&2));
        reverse.map(|m| (m.log_ns - start_ns) as f64 * 1e-9).fold(f64::INFINITY, f64::min)
    }

    /// Appends a log that was driven after this one, without a pause.
    pub(crate) fn append(&mut self, later: &Self) {
        let shift_ns = self.start_ns() + (self.length_s() * 1e9) as u64 + 20_000_000 - later.start_ns();
        for message in &later.messages {
            let mut message = message.clone();
            let stamp_ns = message.stamp_ns() + shift_ns;
            message.log_ns += shift_ns;
            message.publish_ns += shift_ns;
            message.set_stamp_ns(stamp_ns);
            self.messages.push(message);
        }
    }
}
