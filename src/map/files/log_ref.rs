//! A log behind a map: which bytes it was, and what of them could not be used.

use serde::{Deserialize, Serialize};

/// A log that was read.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LogRef {
    /// SHA-256 of the file; of a recording in several files, of their hashes in hexadecimal, one after the other.
    pub sha256: String,
    /// File name without its folder; of several files `first … last`.
    pub file: String,
    /// Size [bytes].
    pub bytes: u64,
    /// What of it could not be used; absent when everything could.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<LogLoss>,
}

/// What of a log could not be used.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LogLoss {
    /// Lost messages, on any topic; absent when the log does not count them.
    pub messages: Option<u64>,
    /// Messages of the wanted topics that do not fit their schema.
    pub unreadable_messages: u64,
    /// Damaged places.
    pub places: u64,
    /// Bytes of these places.
    pub bytes: u64,
    /// Messages that could be read, on any topic.
    pub messages_read: u64,
}

impl LogLoss {
    /// The share of the log that is lost, 0 to 1: of its messages, or of its `bytes` when the messages are not counted.
    pub fn share(&self, bytes: u64) -> f64 {
        let of = |lost: u64, rest: u64| lost as f64 / (lost + rest).max(1) as f64;
        match self.messages {
            Some(lost) => of(lost + self.unreadable_messages, self.messages_read.saturating_sub(self.unreadable_messages)),
            None => of(self.bytes, bytes.saturating_sub(self.bytes)),
        }
    }
}

impl std::fmt::Display for LogLoss {
    /// As in `12 messages lost in 3 damaged places (40960 bytes)`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let messages = self.messages.map_or("an unknown number of".to_owned(), |n| n.to_string());
        write!(f, "{messages} messages lost in {} damaged places ({} bytes)", self.places, self.bytes)?;
        if self.unreadable_messages > 0 {
            write!(f, ", {} do not fit their schema", self.unreadable_messages)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lost_share_is_that_of_the_messages_or_without_a_count_of_the_bytes() {
        let loss = LogLoss { messages: Some(10), unreadable_messages: 5, places: 1, bytes: 100, messages_read: 90 };
        assert!((loss.share(1000) - 0.15).abs() < 1e-12);
        assert!((LogLoss { messages: None, ..loss }.share(1000) - 0.1).abs() < 1e-12);
    }
}
