//! Logs with one defect each, built here: what is intact is used, what is lost is reported, nothing panics.
#![allow(clippy::unwrap_used, missing_docs)]

use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, WriteOptions, Writer};
use pivot_cal::internals::survey_bytes;
use pivot_cal::log::{Depth, Error, LogSurvey, Recording, SignalMap, Source, VehicleOverrides, Why, read_bytes};
use std::collections::BTreeMap;
use std::io::Cursor;

const MESSAGES: u64 = 900;
const DRIVE: &str = "/drive";

/// How a log is written.
#[derive(Clone)]
struct Form {
    compression: Option<Compression>,
    chunks: bool,
    summary: bool,
    indexes: bool,
    repeated_channels: bool,
}

const SOUND: Form = Form { compression: Some(Compression::Zstd), chunks: true, summary: true, indexes: true, repeated_channels: true };

/// A log of 900 messages of one topic, 10 ms apart, in about ten chunks; the values are the message's number.
fn log(form: &Form) -> Vec<u8> {
    let options = WriteOptions::new()
        .compression(form.compression)
        .use_chunks(form.chunks)
        .chunk_size(Some(8 << 10))
        .emit_message_indexes(form.indexes)
        .emit_chunk_indexes(form.indexes)
        .repeat_channels(form.repeated_channels)
        .emit_summary_records(form.summary)
        .emit_summary_offsets(form.summary);
    let mut writer = Writer::with_options(Cursor::new(Vec::new()), options).unwrap();
    let channel = writer.add_channel(0, DRIVE, "json", &BTreeMap::new()).unwrap();
    for number in 0..MESSAGES {
        let time = 1_700_000_000_000_000_000 + number * 10_000_000;
        let text =
            format!(r#"{{"n":{number},"speed_mps":{},"torque_cmd_nm":{},"steer_angle_deg":90.5}}"#, number as f64 * 1e-3, number % 40);
        let header = MessageHeader { channel_id: channel, sequence: number as u32, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn source() -> Source {
    let map = "
        [vehicle]
        wheelbase_m = 0.9
        wheel_radius_m = 0.1
        [signals]
        speed = { path = '/drive.speed_mps' }
        torque = { path = '/drive.torque_cmd_nm' }
        angle = { path = '/drive.steer_angle_deg', unit = 'deg' }
        ";
    Source::Map(SignalMap::from_toml(map).unwrap())
}

fn read(bytes: Vec<u8>) -> Result<Recording, Error> {
    read_bytes(bytes, "log.mcap", &source(), &VehicleOverrides::default())
}

fn look(bytes: Vec<u8>) -> LogSurvey {
    survey_bytes(bytes, "log.mcap", &source(), Depth::Everything).unwrap()
}

/// Position, body length and opcode of every record at the top level.
fn records(bytes: &[u8]) -> Vec<(usize, usize, u8)> {
    let mut at = 8;
    let mut found = Vec::new();
    while at + 9 <= bytes.len() - 8 {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        found.push((at, length, bytes[at]));
        at += 9 + length;
    }
    found
}

fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    records(bytes).into_iter().filter(|record| record.2 == 6).map(|(at, length, _)| (at, length)).collect()
}

/// Messages in each chunk of a sound log, from its message indexes.
fn messages_per_chunk(bytes: &[u8]) -> Vec<u64> {
    records(bytes).into_iter().filter(|record| record.2 == 7).map(|(_, length, _)| (length as u64 - 6) / 16).collect()
}

/// The numbers of the messages that were read, from their speeds.
fn numbers(recording: &Recording) -> Vec<u64> {
    recording.signals.speed.value.iter().map(|speed| (speed * 1e3).round() as u64).collect()
}

/// Expects that all messages but those of chunk `lost` were read, and that the loss is reported.
#[track_caller]
fn expect_lost_chunk(bytes: Vec<u8>, sound: &[u8], lost: usize) -> Recording {
    let per_chunk = messages_per_chunk(sound);
    let first: u64 = per_chunk[..lost].iter().sum();
    let expected: Vec<u64> = (0..MESSAGES).filter(|n| !(first..first + per_chunk[lost]).contains(n)).collect();
    let recording = read(bytes).unwrap();
    assert_eq!(numbers(&recording), expected);
    assert_eq!(recording.loss.messages_read, expected.len() as u64);
    assert!(recording.loss.is_damaged());
    assert!(recording.loss.bytes_lost > 0);
    recording
}

#[test]
fn a_sound_log_is_read_whole_in_every_form() {
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        for (chunks, summary, indexes, repeated_channels) in [
            (true, true, true, true),
            (true, false, true, true),
            (true, true, false, true),
            (true, true, true, false),
            (true, false, false, false),
            (false, true, true, true),
            (false, false, true, true),
        ] {
            let recording = read(log(&Form { compression, chunks, summary, indexes, repeated_channels })).unwrap();
            assert_eq!(numbers(&recording), (0..MESSAGES).collect::<Vec<_>>());
            assert_eq!(recording.loss.messages_lost, Some(0));
            assert!(!recording.loss.is_damaged(), "{:?}", recording.loss);
        }
    }
}

#[test]
fn a_flipped_byte_in_a_chunk_loses_that_chunk_only() {
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let sound = log(&Form { compression, ..SOUND });
        let (at, length) = chunks(&sound)[3];
        let mut bytes = sound.clone();
        bytes[at + 9 + length - 40] ^= 0x10;
        let recording = expect_lost_chunk(bytes, &sound, 3);
        assert_eq!(recording.loss.messages_lost, Some(messages_per_chunk(&sound)[3]));
        assert_eq!(recording.loss.places[0].topics, [DRIVE]);
        assert_eq!(recording.loss.places[0].offset, at as u64);
    }
}

#[test]
fn a_flipped_byte_in_a_log_without_summary_loses_that_chunk_only() {
    let sound = log(&Form { summary: false, ..SOUND });
    let (at, length) = chunks(&sound)[2];
    let mut bytes = sound.clone();
    bytes[at + 9 + length / 2] ^= 1;
    let recording = expect_lost_chunk(bytes, &sound, 2);
    assert_eq!(recording.loss.messages_lost, Some(messages_per_chunk(&sound)[2]));
}

#[test]
fn a_flipped_byte_in_an_unchunked_log_is_reported_by_the_data_sections_checksum() {
    let mut bytes = log(&Form { chunks: false, ..SOUND });
    let (at, length, _) = records(&bytes).into_iter().filter(|record| record.2 == 5).nth(100).unwrap();
    bytes[at + 9 + length - 8] ^= 1;
    let recording = read(bytes).unwrap();
    assert!(matches!(recording.loss.places[0].why, Why::DataCrc { .. }), "{:?}", recording.loss);
}

#[test]
fn a_truncated_log_gives_every_chunk_before_its_end() {
    let sound = log(&SOUND);
    let (at, length) = chunks(&sound)[5];
    let recording = read(sound[..at + length / 2].to_vec()).unwrap();
    let before: u64 = messages_per_chunk(&sound)[..5].iter().sum();
    assert!(recording.loss.messages_read >= before);
    assert_eq!(numbers(&recording)[..before as usize], (0..before).collect::<Vec<_>>());
    assert_eq!(recording.loss.places[0].why, Why::Truncated);
    assert_eq!(recording.loss.messages_lost, None);
}

#[test]
fn an_uncompressed_chunk_that_is_cut_off_still_gives_its_first_messages() {
    let sound = log(&Form { compression: None, ..SOUND });
    let (at, length) = chunks(&sound)[5];
    let recording = read(sound[..at + length / 2].to_vec()).unwrap();
    let before: u64 = messages_per_chunk(&sound)[..5].iter().sum();
    assert!(recording.loss.messages_read > before + 20, "{:?}", recording.loss);
}

#[test]
fn a_log_cut_at_any_byte_never_panics() {
    let sound = log(&SOUND);
    for length in (0..sound.len()).step_by(97) {
        if let Ok(recording) = read(sound[..length].to_vec()) {
            assert!(recording.loss.is_damaged(), "cut at {length}");
        }
    }
}

#[test]
fn a_footer_that_points_outside_falls_back_to_scanning() {
    let mut bytes = log(&SOUND);
    let footer = bytes.len() - 8 - 20;
    bytes[footer..footer + 8].copy_from_slice(&(1_u64 << 60).to_le_bytes());
    let recording = read(bytes).unwrap();
    assert_eq!(numbers(&recording).len() as u64, MESSAGES);
    assert!(matches!(recording.loss.places[0].why, Why::BadSummary(_)));
}

#[test]
fn a_flipped_byte_in_the_summary_falls_back_to_scanning() {
    let mut bytes = log(&SOUND);
    let footer = bytes.len() - 8 - 20;
    let start = u64::from_le_bytes(bytes[footer..footer + 8].try_into().unwrap()) as usize;
    bytes[start + 60] ^= 4;
    let survey = look(bytes);
    assert!(!survey.indexed);
    assert_eq!(survey.messages, Some(MESSAGES));
}

#[test]
fn a_chunk_that_claims_terabytes_is_refused_without_allocating() {
    let sound = log(&SOUND);
    let mut bytes = sound.clone();
    let (at, _) = chunks(&sound)[4];
    bytes[at + 9 + 16..at + 9 + 24].copy_from_slice(&(1_u64 << 42).to_le_bytes());
    let recording = expect_lost_chunk(bytes, &sound, 4);
    assert!(matches!(recording.loss.places[0].why, Why::TooLarge { .. }));
}

#[test]
fn an_lz4_chunk_that_claims_more_than_its_bytes_can_hold_is_refused_without_being_filled() {
    let sound = log(&Form { compression: Some(Compression::Lz4), ..SOUND });
    let mut bytes = sound.clone();
    let (at, length) = chunks(&sound)[4];
    bytes[at + 9 + 16..at + 9 + 24].copy_from_slice(&(200_u64 << 20).to_le_bytes());
    let recording = expect_lost_chunk(bytes, &sound, 4);
    assert!(matches!(recording.loss.places[0].why, Why::TooLarge { allowed, .. } if allowed < 256 * length as u64));
}

#[test]
fn a_chunk_that_declares_too_little_is_refused() {
    for compression in [None, Some(Compression::Zstd), Some(Compression::Lz4)] {
        let sound = log(&Form { compression, ..SOUND });
        let mut bytes = sound.clone();
        let (at, _) = chunks(&sound)[4];
        bytes[at + 9 + 16..at + 9 + 24].copy_from_slice(&100_u64.to_le_bytes());
        expect_lost_chunk(bytes, &sound, 4);
    }
}

#[test]
fn a_message_index_of_wild_length_behind_a_lost_chunk_ends_the_count() {
    for length in [u64::MAX, u64::MAX - 8, u64::MAX - 20_000, 1 << 40] {
        let sound = log(&SOUND);
        let mut bytes = sound.clone();
        let (at, body) = chunks(&sound)[3];
        bytes[at + 9 + body - 40] ^= 0x10;
        let index = at + 9 + body;
        assert_eq!(bytes[index], 7);
        bytes[index + 1..index + 9].copy_from_slice(&length.to_le_bytes());
        expect_lost_chunk(bytes, &sound, 3);
    }
}

#[test]
fn an_unknown_compression_loses_that_chunk_only() {
    let sound = log(&SOUND);
    let mut bytes = sound.clone();
    let (at, _) = chunks(&sound)[1];
    let name = at + 9 + 8 + 8 + 8 + 4 + 4;
    assert_eq!(&bytes[name..name + 4], b"zstd");
    bytes[name..name + 4].copy_from_slice(b"snap");
    let recording = expect_lost_chunk(bytes, &sound, 1);
    assert_eq!(recording.loss.places[0].why, Why::UnknownCompression("snap".into()));
}

#[test]
fn a_chunk_with_a_wild_record_length_is_passed_over() {
    for length in [0_u64, 7, 1 << 20, u64::MAX] {
        let sound = log(&SOUND);
        let mut bytes = sound.clone();
        let (at, _) = chunks(&sound)[6];
        bytes[at + 1..at + 9].copy_from_slice(&length.to_le_bytes());
        expect_lost_chunk(bytes, &sound, 6);
    }
}

/// A log of three topics of different rates in chunks; the values of `/drive` are the message's number.
fn three_topics(summary: bool) -> Vec<u8> {
    let options = WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .chunk_size(Some(8 << 10))
        .emit_summary_records(summary)
        .emit_summary_offsets(summary);
    let mut writer = Writer::with_options(Cursor::new(Vec::new()), options).unwrap();
    let channels = [DRIVE, "/imu", "/status"].map(|topic| writer.add_channel(0, topic, "json", &BTreeMap::new()).unwrap());
    for number in 0..MESSAGES {
        let time = 1_700_000_000_000_000_000 + number * 10_000_000;
        let text = format!(r#"{{"speed_mps":{},"torque_cmd_nm":{},"steer_angle_deg":90.5}}"#, number as f64 * 1e-3, number % 40);
        for (channel, every) in channels.into_iter().zip([1, 2, 150]) {
            if number % every == 0 {
                let header = MessageHeader { channel_id: channel, sequence: number as u32, log_time: time, publish_time: time };
                writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
            }
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

#[test]
fn the_loss_of_a_chunk_is_reported_by_place_bytes_and_topics_and_everything_behind_it_is_read() {
    type Defect = fn(&mut [u8], usize, usize);
    let defects: [(&str, Defect); 4] = [
        ("a claim of terabytes", |bytes, body, _| bytes[body + 16..body + 24].copy_from_slice(&(1_u64 << 42).to_le_bytes())),
        ("an unknown compression", |bytes, body, _| bytes[body + 32..body + 36].copy_from_slice(b"snap")),
        ("a flipped byte", |bytes, body, length| bytes[body + length - 40] ^= 4),
        ("a wrong checksum", |bytes, body, _| bytes[body + 24] ^= 1),
    ];
    for summary in [true, false] {
        let sound = three_topics(summary);
        let whole = look(sound.clone());
        let messages =
            |survey: &LogSurvey| survey.topics.iter().map(|topic| (topic.topic.clone(), topic.messages.unwrap())).collect::<Vec<_>>();
        // a chunk without /status, which is written every 150th time: it is not said to have lost anything
        let (at, length) = chunks(&sound)[4];
        let indexes = records(&sound).into_iter().skip_while(|record| record.0 <= at).take_while(|record| record.2 == 7);
        let lost: Vec<u64> = indexes.map(|(_, length, _)| (length as u64 - 6) / 16).collect();
        assert_eq!(lost.len(), 2);
        for (name, defect) in defects {
            let mut bytes = sound.clone();
            defect(&mut bytes, at + 9, length);
            let survey = look(bytes.clone());
            let loss = survey.loss.clone().unwrap();
            assert_eq!(loss.places.len(), 1, "{name}: {loss:?}");
            let place = &loss.places[0];
            assert_eq!((place.offset, place.bytes, place.messages), (at as u64, length as u64 + 9, Some(lost[0] + lost[1])), "{name}");
            assert_eq!(place.topics, [DRIVE, "/imu"], "{name}");
            assert_eq!((loss.bytes_lost, loss.messages_lost), (place.bytes, place.messages), "{name}");
            assert_eq!(loss.messages_read + lost[0] + lost[1], whole.loss.as_ref().unwrap().messages_read, "{name}");
            let mut expected = messages(&whole);
            expected[0].1 -= lost[0];
            expected[1].1 -= lost[1];
            assert_eq!(messages(&survey), expected, "{name}");
            // what is read is what was written: each number once, in order, but for one gap
            let numbers = numbers(&read(bytes).unwrap());
            let gap = numbers.windows(2).position(|pair| pair[1] != pair[0] + 1).unwrap();
            assert_eq!(numbers[gap + 1] - numbers[gap] - 1, lost[0], "{name}");
            assert_eq!((numbers[0], numbers[numbers.len() - 1], numbers.len() as u64), (0, MESSAGES - 1, MESSAGES - lost[0]), "{name}");
        }
    }
}

#[test]
fn garbage_between_chunks_is_passed_over() {
    let sound = log(&Form { summary: false, ..SOUND });
    let (at, _) = chunks(&sound)[3];
    let mut bytes = sound[..at].to_vec();
    bytes.extend([0xa5; 777]);
    bytes.extend(&sound[at..]);
    let recording = read(bytes).unwrap();
    assert_eq!(numbers(&recording).len() as u64, MESSAGES);
    assert_eq!(recording.loss.bytes_lost, 777);
}

#[test]
fn garbage_between_messages_of_an_unchunked_log_is_passed_over() {
    let sound = log(&Form { chunks: false, summary: false, ..SOUND });
    let (at, ..) = records(&sound).into_iter().filter(|record| record.2 == 5).nth(50).unwrap();
    let mut bytes = sound[..at].to_vec();
    bytes.extend([0; 333]);
    bytes.extend(&sound[at..]);
    let recording = read(bytes).unwrap();
    assert_eq!(numbers(&recording).len() as u64, MESSAGES);
    assert_eq!(recording.loss.places[0].bytes, 333);
}

#[test]
fn messages_of_a_channel_that_is_not_described_are_counted() {
    let mut bytes = log(&Form { chunks: false, summary: false, ..SOUND });
    let lost: Vec<_> = records(&bytes).into_iter().filter(|record| record.2 == 5).skip(3).step_by(10).collect();
    for (at, _, _) in &lost {
        bytes[at + 9] = 99;
    }
    let recording = read(bytes).unwrap();
    assert_eq!(recording.loss.messages_read, MESSAGES - MESSAGES / 10);
    let place = recording.loss.places.iter().find(|damage| damage.why == Why::NoChannel { channel: 99 }).unwrap();
    assert_eq!((place.offset, place.messages), (lost[0].0 as u64, Some(MESSAGES / 10)));
    assert_eq!(place.bytes, lost.iter().map(|(_, length, _)| *length as u64 + 9).sum::<u64>());
}

#[test]
fn broken_payloads_are_skipped_and_counted() {
    let mut bytes = log(&Form { chunks: false, summary: false, ..SOUND });
    for (at, _, _) in records(&bytes).into_iter().filter(|record| record.2 == 5).step_by(9).collect::<Vec<_>>() {
        bytes[at + 9 + 22] = b'[';
    }
    let recording = read(bytes).unwrap();
    assert_eq!(recording.loss.broken_messages[DRIVE], MESSAGES / 9);
    assert_eq!(numbers(&recording).len() as u64, MESSAGES - MESSAGES / 9);
}

#[test]
fn values_that_are_no_numbers_are_dropped_and_counted() {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema("pkg/Drive", "ros2msg", b"float64 speed_mps\nfloat64 torque_cmd_nm\nfloat64 steer_angle_deg\n").unwrap();
    let channel = writer.add_channel(schema, DRIVE, "cdr", &BTreeMap::new()).unwrap();
    for (number, speed) in [1.0, f64::NAN, 2.0, f64::INFINITY, f64::NEG_INFINITY, 3.0].into_iter().enumerate() {
        let header = MessageHeader { channel_id: channel, sequence: 0, log_time: number as u64, publish_time: 0 };
        let payload = [&[0, 1, 0, 0], &[speed, 7.0, 9.0].map(f64::to_le_bytes).concat()[..]].concat();
        writer.write_to_known_channel(&header, &payload).unwrap();
    }
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    let recording = read(bytes.clone()).unwrap();
    assert_eq!(recording.signals.speed.value, [1.0, 2.0, 3.0]);
    assert_eq!(recording.signals.torque.len(), 6);
    for loss in [recording.loss, look(bytes).loss.unwrap()] {
        assert_eq!(loss.not_finite, BTreeMap::from([("speed".to_owned(), 3)]));
        assert!(!loss.is_damaged());
    }
}

#[test]
fn a_jump_of_the_clock_and_a_log_time_beyond_reason_are_kept_in_their_place() {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    let channel = writer.add_channel(0, DRIVE, "json", &BTreeMap::new()).unwrap();
    for (time, speed) in [(1, 1), (2, 2), (9_000_000_000_000_000_000, 3), (u64::MAX, 4)] {
        let header = MessageHeader { channel_id: channel, sequence: 0, log_time: time, publish_time: time };
        let text = format!(r#"{{"speed_mps":{speed},"torque_cmd_nm":2,"steer_angle_deg":3}}"#);
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    let recording = read(writer.into_inner().into_inner()).unwrap();
    assert_eq!(recording.signals.speed.time_ns, [1, 2, 9_000_000_000_000_000_000, i64::MAX]);
}

#[test]
fn a_repeated_chunk_bomb_that_the_end_cuts_off_gives_no_more_than_it_declares() {
    // zeros compress a thousandfold: the chunk declares little, holds much, and is cut
    let packed = zstd::encode_all(&vec![0_u8; 64 << 20][..], 1).unwrap();
    let sound = log(&SOUND);
    let (at, _) = chunks(&sound)[5];
    let mut bytes = sound[..at].to_vec();
    let mut body = sound[at + 9..at + 9 + 32 + 4].to_vec();
    body[16..24].copy_from_slice(&1000_u64.to_le_bytes());
    body.extend((packed.len() as u64 + 50).to_le_bytes());
    body.extend(&packed);
    bytes.push(6);
    bytes.extend((body.len() as u64 + 50).to_le_bytes());
    bytes.extend(body);
    let recording = read(bytes).unwrap();
    assert_eq!(recording.loss.messages_read, messages_per_chunk(&sound)[..5].iter().sum::<u64>());
}

#[test]
fn attachments_metadata_and_unknown_records_are_kept_out_of_the_way() {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    let channel = writer.add_channel(0, DRIVE, "json", &BTreeMap::new()).unwrap();
    let attachment = mcap::Attachment {
        log_time: 1,
        create_time: 1,
        name: "map.bin".into(),
        media_type: "application/octet-stream".into(),
        data: vec![6; 100_000].into(),
    };
    writer.attach(&attachment).unwrap();
    writer.write_private_record(0x85, &[5; 64], mcap::write::PrivateRecordOptions::IncludeInChunks.into()).unwrap();
    let mut metadata = BTreeMap::new();
    for (key, value) in [("wheelbase_m", "1.1"), ("wheel_radius_m", "0.15"), ("test_angle_deg", "85")] {
        metadata.insert(key.to_owned(), value.to_owned());
    }
    writer.write_metadata(&Metadata { name: "pivot-cal/vehicle".into(), metadata }).unwrap();
    for number in 0..10 {
        let header = MessageHeader { channel_id: channel, sequence: 0, log_time: number, publish_time: number };
        writer.write_to_known_channel(&header, br#"{"speed_mps":1,"torque_cmd_nm":2,"steer_angle_deg":3}"#).unwrap();
    }
    writer.finish().unwrap();
    let bytes = writer.into_inner().into_inner();
    let Source::Map(mut map) = source() else { unreachable!() };
    map.vehicle = VehicleOverrides::default();
    let recording = read_bytes(bytes, "log.mcap", &Source::Map(map), &VehicleOverrides::default()).unwrap();
    assert_eq!(recording.signals.speed.len(), 10);
    assert_eq!((recording.vehicle.wheelbase_m, recording.vehicle.test_angle_deg), (1.1, 85.0));
    assert!(!recording.loss.is_damaged());
}

#[test]
fn messages_out_of_order_and_with_equal_stamps_are_sorted_stably() {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    let channel = writer.add_channel(0, DRIVE, "json", &BTreeMap::new()).unwrap();
    for (time, speed) in [(30, 1), (10, 2), (20, 3), (10, 4), (30, 5)] {
        let header = MessageHeader { channel_id: channel, sequence: 0, log_time: time, publish_time: time };
        let text = format!(r#"{{"speed_mps":{speed},"torque_cmd_nm":2,"steer_angle_deg":3}}"#);
        writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
    }
    writer.finish().unwrap();
    let recording = read(writer.into_inner().into_inner()).unwrap();
    assert_eq!(recording.signals.speed.time_ns, [10, 10, 20, 30, 30]);
    assert_eq!(recording.signals.speed.value, [2.0, 4.0, 3.0, 1.0, 5.0]);
}

#[test]
fn a_topic_whose_type_changes_is_read_through_all_its_channels() {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    let json = writer.add_channel(0, DRIVE, "json", &BTreeMap::new()).unwrap();
    let schema = writer.add_schema("pkg/Drive", "ros2msg", b"float64 speed_mps\nfloat64 torque_cmd_nm\nfloat64 steer_angle_deg\n").unwrap();
    let cdr = writer.add_channel(schema, DRIVE, "cdr", &BTreeMap::new()).unwrap();
    let header = |channel_id, time| MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
    writer.write_to_known_channel(&header(json, 1), br#"{"speed_mps":"1.5","torque_cmd_nm":2,"steer_angle_deg":3}"#).unwrap();
    let mut payload = vec![0, 1, 0, 0];
    for value in [2.5_f64, 7.0, 9.0] {
        payload.extend(value.to_le_bytes());
    }
    writer.write_to_known_channel(&header(cdr, 2), &payload).unwrap();
    writer.finish().unwrap();
    let recording = read(writer.into_inner().into_inner()).unwrap();
    assert_eq!(recording.signals.speed.value, [1.5, 2.5]);
}

#[test]
fn what_is_no_log_is_a_clear_error() {
    let empty = Writer::new(Cursor::new(Vec::new())).and_then(|mut w| w.finish().map(|_| w.into_inner().into_inner())).unwrap();
    assert!(matches!(read(empty), Err(Error::NoMessages { damage: None })));
    assert!(matches!(read(Vec::new()), Err(Error::Empty)));
    assert!(matches!(read(vec![0xd3; 20_000]), Err(Error::NotMcap { .. })));
    assert!(matches!(read(b"\x89MCAP0\r\n".to_vec()), Err(Error::NoMessages { .. })));
    let mut garbage = b"\x89MCAP0\r\n".to_vec();
    garbage.extend((0_u32..20_000).map(|n| (n.wrapping_mul(2_654_435_761) >> 13) as u8));
    assert!(matches!(read(garbage), Err(Error::NoMessages { damage: Some(_) })));
    let packed = zstd::encode_all(&log(&SOUND)[..], 0).unwrap();
    assert!(read(packed).unwrap_err().to_string().contains("zstd -d"));
}

#[test]
fn a_missing_topic_field_or_signal_says_what_the_log_has() {
    let read = |path: &str| {
        let map = format!(
            "[vehicle]\nwheelbase_m = 1\nwheel_radius_m = 0.1\n[signals]\ntorque = {{ path = '/drive.torque_cmd_nm' }}\nangle = {{ path = '/drive.steer_angle_deg', unit = 'deg' }}\nspeed = {{ path = '{path}' }}"
        );
        read_bytes(log(&SOUND), "log.mcap", &Source::Map(SignalMap::from_toml(&map).unwrap()), &VehicleOverrides::default()).unwrap_err()
    };
    assert!(read("/driv.speed_mps").to_string().contains("the nearest is /drive"));
    assert!(matches!(read("/drive.sped"), Error::NoValues { messages: MESSAGES, .. }));
    let none = Source::Map(SignalMap::from_toml("[signals]\n").unwrap());
    let error = read_bytes(log(&SOUND), "log.mcap", &none, &VehicleOverrides::default()).unwrap_err().to_string();
    assert!(error.contains("/drive.speed_mps"), "{error}");
}

#[test]
fn the_threads_do_not_change_the_result() {
    let bytes = log(&SOUND);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let four = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    assert_eq!(one.install(|| read(bytes.clone()).unwrap()), four.install(|| read(bytes.clone()).unwrap()));
}
