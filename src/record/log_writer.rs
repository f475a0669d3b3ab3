//! Writes a log of ROS 2 messages as MCAP: chunked, zstd, with summary, indexes and embedded schemas.
//!
//! Messages are kept until the end and written in the order of their log times, so that the bytes depend only on the messages.

use crate::record::error::{Error, Result};
use crate::record::message::RosMessage;
use crate::record::schema;
use std::collections::BTreeMap;
use std::io::Cursor;

/// Uncompressed size of a chunk [bytes]: some seconds of a log, so that a seek reads little data.
const CHUNK_BYTES: u64 = 512 * 1024;
/// zstd level: above it the size falls by less than a per cent and the time doubles.
const ZSTD_LEVEL: u32 = 9;

struct OpenTopic {
    name: String,
    type_name: &'static str,
    count: u32,
}

struct ChannelEntry {
    topic: usize,
    sequence: u32,
    log_time_ns: u64,
    publish_time_ns: u64,
    data: Vec<u8>,
}

/// A log under construction.
#[derive(Default)]
pub(crate) struct LogWriter {
    topics: Vec<OpenTopic>,
    by_name: BTreeMap<String, usize>,
    entries: Vec<ChannelEntry>,
    metadata: Vec<mcap::records::Metadata>,
}

impl LogWriter {
    /// An empty log.
    pub(crate) fn new() -> Self {
        Self::default()
    }

    /// Adds a metadata record.
    pub(crate) fn metadata<'a>(&mut self, name: &str, entries: impl IntoIterator<Item = (&'a str, String)>) {
        let metadata = entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        self.metadata.push(mcap::records::Metadata { name: name.to_owned(), metadata });
    }

    /// Adds a message. The first message of a topic determines its type. Times may be in any order; messages of equal log time keep the
    /// order of the calls.
    ///
    /// # Errors
    /// The type differs from that of the topic's first message.
    pub(crate) fn write(&mut self, topic: &str, log_time_ns: u64, publish_time_ns: u64, message: &RosMessage<'_>) -> Result<()> {
        let index = if let Some(&index) = self.by_name.get(topic) {
            index
        } else {
            self.topics.push(OpenTopic { name: topic.to_owned(), type_name: message.type_name(), count: 0 });
            self.by_name.insert(topic.to_owned(), self.topics.len() - 1);
            self.topics.len() - 1
        };
        let opened = &mut self.topics[index];
        if opened.type_name != message.type_name() {
            return Err(Error::TopicType { topic: topic.to_owned(), opened: opened.type_name, written: message.type_name() });
        }
        opened.count += 1;
        let sequence = opened.count;
        self.entries.push(ChannelEntry { topic: index, sequence, log_time_ns, publish_time_ns, data: message.to_cdr() });
        Ok(())
    }

    /// Number of messages so far.
    pub(crate) fn len(&self) -> usize {
        self.entries.len()
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// Any error of the MCAP writer.
    pub(crate) fn finish(mut self) -> Result<Vec<u8>> {
        let mut writer = mcap::WriteOptions::new()
            .profile("ros2")
            .library(concat!("pivot-cal ", env!("CARGO_PKG_VERSION")))
            .compression(Some(mcap::Compression::Zstd))
            .compression_level(ZSTD_LEVEL)
            // single-threaded: the bytes must not depend on the machine's number of cores
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .create(Cursor::new(Vec::new()))?;
        for record in &self.metadata {
            writer.write_metadata(record)?;
        }
        let mut channels = Vec::with_capacity(self.topics.len());
        for topic in &self.topics {
            let schema = writer.add_schema(topic.type_name, "ros2msg", schema::text(topic.type_name).as_bytes())?;
            channels.push(writer.add_channel(schema, &topic.name, "cdr", &BTreeMap::new())?);
        }
        self.entries.sort_by_key(|entry| entry.log_time_ns);
        for entry in &self.entries {
            let header = mcap::records::MessageHeader {
                channel_id: channels[entry.topic],
                sequence: entry.sequence,
                log_time: entry.log_time_ns,
                publish_time: entry.publish_time_ns,
            };
            writer.write_to_known_channel(&header, &entry.data)?;
        }
        writer.finish()?;
        Ok(writer.into_inner().into_inner())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn example() -> LogWriter {
        let mut log = LogWriter::new();
        log.metadata("pivot-cal/vehicle", [("wheelbase_m", "0.9".to_owned())]);
        log.write("/b", 20, 20, &RosMessage::Float64(2.0)).unwrap();
        log.write("/a", 10, 10, &RosMessage::Bool(true)).unwrap();
        log.write("/b", 5, 4, &RosMessage::Float64(1.0)).unwrap();
        log
    }

    #[test]
    fn messages_are_read_back_in_the_order_of_their_log_times() {
        let bytes = example().finish().unwrap();
        let read: Vec<_> = mcap::MessageStream::new(&bytes).unwrap().map(|m| m.unwrap()).collect();
        let times: Vec<_> = read.iter().map(|m| (m.channel.topic.clone(), m.log_time, m.publish_time)).collect();
        assert_eq!(times, [("/b".to_owned(), 5, 4), ("/a".to_owned(), 10, 10), ("/b".to_owned(), 20, 20)]);
        let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
        assert_eq!(summary.metadata_indexes.len(), 1);
        assert_eq!(summary.stats.unwrap().message_count, 3);
    }

    #[test]
    fn the_same_messages_give_the_same_bytes() {
        assert_eq!(example().finish().unwrap(), example().finish().unwrap());
    }

    #[test]
    fn a_topic_keeps_its_type() {
        let error = example().write("/a", 30, 30, &RosMessage::Int8(1)).unwrap_err();
        assert_eq!(error.to_string(), "topic /a was opened as std_msgs/msg/Bool and is written as std_msgs/msg/Int8");
    }
}
