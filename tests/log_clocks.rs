//! Logs whose messages mean something else than one reading per period, or whose clocks are wrong: each is made from a log of the simulator.
#![allow(clippy::unwrap_used, missing_docs)]

use mcap::{MessageStream, Writer};
use pivot_cal::campaign::{Survey, SurveySettings};
use pivot_cal::fit::{FitSettings, fit};
use pivot_cal::internals::{Campaign, VehicleFile, ledger, record, with_missing};
use pivot_cal::log::{Recording, SignalMap, Source, VehicleOverrides, read_bytes};
use pivot_cal::map::{AccelTable, Table1File};
use pivot_cal::signal::Track;
use std::borrow::Cow;
use std::io::Cursor;
use std::sync::LazyLock;

const CAMPAIGN: &str = "[[runs]]\ntorque_nm = [-16, -8, 0]\nstart_speed_mps = 0.8\nspin_up_nm = 36\nend_speed_mps = 0.2\nhold_s = 2.5\nrepeats = 3\n\
                        pause_s = 0.5\n[[runs]]\ntorque_nm = [12, 18, 26, 36]\nhold_s = 2.5\nrepeats = 3\npause_s = 0.5\n";
const COMMAND: &str = "/drive/torque_command";
const FEEDBACK: &str = "/drive/torque_feedback";
const ENCODER: &str = "/joint_states";
const STAMPED: [&str; 3] = [ENCODER, "/eps/joint_states", "/imu/twist"];
const SECOND: i64 = 1_000_000_000;

static LOG: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let vehicle = VehicleFile::from_toml(include_str!("../data/vehicles/scrubber.toml")).unwrap();
    record(&vehicle, &Campaign::from_toml(CAMPAIGN).unwrap(), Some(5)).unwrap().bytes
});

/// One message: its times [ns since the log's first message] and its payload.
#[derive(Clone)]
struct Entry {
    topic: String,
    log_ns: i64,
    publish_ns: i64,
    data: Vec<u8>,
}

impl Entry {
    fn value(&self) -> f64 {
        f64::from_le_bytes(self.data[4..12].try_into().unwrap())
    }

    fn set_value(&mut self, value: f64) {
        self.data[4..12].copy_from_slice(&value.to_le_bytes());
    }

    /// Adds to the stamp of a message that has one.
    fn stamp_later(&mut self, by_ns: i64) {
        if !STAMPED.contains(&self.topic.as_str()) {
            return;
        }
        let part = |from: usize| i64::from(u32::from_le_bytes(self.data[from..from + 4].try_into().unwrap()));
        let stamp_ns = part(4) * SECOND + part(8) + by_ns;
        self.data[4..8].copy_from_slice(&u32::try_from(stamp_ns / SECOND).unwrap().to_le_bytes());
        self.data[8..12].copy_from_slice(&u32::try_from(stamp_ns % SECOND).unwrap().to_le_bytes());
    }
}

/// The log with each message as `change` leaves it, in the order of the file: none, one or several.
fn changed(mut change: impl FnMut(Entry) -> Vec<Entry>) -> Vec<u8> {
    let mut writer = Writer::new(Cursor::new(Vec::new())).unwrap();
    let mut start_ns = None;
    for message in MessageStream::new(&LOG).unwrap() {
        let message = message.unwrap();
        let start_ns = *start_ns.get_or_insert(message.log_time as i64);
        let (log_ns, publish_ns) = (message.log_time as i64 - start_ns, message.publish_time as i64 - start_ns);
        let entry = Entry { topic: message.channel.topic.clone(), log_ns, publish_ns, data: message.data.to_vec() };
        for entry in change(entry) {
            let (log_time, publish_time) = ((entry.log_ns + start_ns) as u64, (entry.publish_ns + start_ns) as u64);
            writer.write(&mcap::Message { data: Cow::Owned(entry.data), log_time, publish_time, ..message.clone() }).unwrap();
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn read(bytes: Vec<u8>) -> Recording {
    let overrides = VehicleOverrides { wheelbase_m: Some(0.9), wheel_radius_m: Some(0.12), ..VehicleOverrides::default() };
    read_bytes(bytes, "drive.mcap", &Source::Detect, &overrides).unwrap()
}

/// The usual log, read.
fn usual() -> Recording {
    read(changed(|entry| vec![entry]))
}

/// Largest difference of the times of a signal from those of the usual log, apart from a common offset, and that offset [s].
fn differences(found: &pivot_cal::log::Signal, usual: &pivot_cal::log::Signal) -> (f64, f64) {
    assert_eq!(found.len(), usual.len());
    let mut apart: Vec<f64> = found.time_ns.iter().zip(&usual.time_ns).map(|(a, b)| (a - b) as f64 * 1e-9).collect();
    apart.sort_unstable_by(f64::total_cmp);
    let middle = apart[apart.len() / 2];
    (apart.iter().map(|a| (a - middle).abs()).fold(0.0, f64::max), middle)
}

#[track_caller]
fn noted(recording: &Recording, words: &[&str]) {
    assert!(recording.clock_notes.iter().any(|note| words.iter().all(|word| note.contains(word))), "{:?}", recording.clock_notes);
}

fn fitted(recording: &Recording) -> Table1File {
    let survey = Survey::new(Track::new(recording).unwrap(), &SurveySettings::default()).unwrap();
    fit(vec![survey], &FitSettings::default()).unwrap().file
}

/// Root mean square difference of two surfaces where both are measured [m/s²].
fn apart_mps2(a: &Table1File, b: &Table1File) -> f64 {
    let (a, b) = (a.maps[0].surface.table().unwrap(), b.maps[0].surface.table().unwrap());
    let at = |table: &AccelTable, v: f64, u: f64| table.accel_from_torque_clamped(v, u).unwrap();
    let places = (1..8).flat_map(|v| [-14.0, -4.0, 12.0, 20.0, 30.0].map(|u| (0.1 * f64::from(v), u)));
    let squares: Vec<f64> = places.map(|(v, u)| (at(&a, v, u) - at(&b, v, u)).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn a_command_logged_on_change_makes_the_map_of_the_periodic_one() {
    let mut last = f64::NAN;
    let sparse = changed(|entry| {
        let is_same = entry.topic == COMMAND && entry.value() == last;
        last = if entry.topic == COMMAND { entry.value() } else { last };
        if is_same { Vec::new() } else { vec![entry] }
    });
    let sparse = read(sparse);
    assert!(sparse.signals.torque.len() < 120);
    let track = Track::new(&sparse).unwrap();
    assert!(track.notes.iter().any(|note| note.contains("torque is logged on change")), "{:?}", track.notes);
    let apart = apart_mps2(&fitted(&sparse), &fitted(&usual()));
    assert!(apart < 0.01, "{apart}");
}

#[test]
fn stamps_on_another_clock_are_moved_by_their_earliest_arrivals() {
    for ahead_s in [-3600.0, -0.5, 0.4, 2.0] {
        let by_ns = (ahead_s * SECOND as f64) as i64;
        let found = read(changed(|mut entry| {
            entry.stamp_later(by_ns);
            vec![entry]
        }));
        let (scatter, offset) = differences(&found.signals.speed, &usual().signals.speed);
        assert!(scatter < 1e-6 && offset.abs() < 0.006, "{ahead_s}: {scatter} {offset}");
        noted(&found, &["another clock", "speed"]);
    }
}

#[test]
fn a_drifting_clock_is_brought_back() {
    let mut first = None;
    let found = read(changed(|mut entry| {
        let from = *first.get_or_insert(entry.log_ns);
        entry.stamp_later((entry.log_ns - from) / 1000);
        vec![entry]
    }));
    let (scatter, _) = differences(&found.signals.speed, &usual().signals.speed);
    assert!(scatter < 1.5e-3, "{scatter}");
    noted(&found, &["speed", "drifts"]);
}

#[test]
fn a_recorder_whose_clock_is_set_back_goes_on() {
    let found = read(changed(|mut entry| {
        if entry.log_ns > 40 * SECOND {
            entry.log_ns -= 13 * SECOND;
            entry.publish_ns -= 13 * SECOND;
            entry.stamp_later(-13 * SECOND);
        }
        vec![entry]
    }));
    let (scatter, _) = differences(&found.signals.speed, &usual().signals.speed);
    assert!(scatter < 0.02, "{scatter}");
    noted(&found, &["set back by 13.0 s"]);
}

#[test]
fn encoder_messages_that_come_five_at_a_time_are_five_readings() {
    let mut waiting: Vec<Entry> = Vec::new();
    let found = read(changed(|entry| {
        if entry.topic != ENCODER {
            return vec![entry];
        }
        waiting.push(entry.clone());
        if waiting.len() < 5 {
            return Vec::new();
        }
        let together = std::mem::take(&mut waiting);
        let stamp = entry.data[4..12].to_vec();
        together
            .into_iter()
            .map(|mut one| {
                (one.log_ns, one.publish_ns) = (entry.log_ns, entry.publish_ns);
                one.data[4..12].copy_from_slice(&stamp);
                one
            })
            .collect()
    }));
    let mut usual = usual().signals.speed;
    usual.time_ns.truncate(found.signals.speed.len());
    usual.value.truncate(found.signals.speed.len());
    assert_eq!(found.signals.speed.value, usual.value);
    let (mut off, count) = (0, usual.len());
    let (_, offset) = differences(&found.signals.speed, &usual);
    for (a, b) in found.signals.speed.time_ns.iter().zip(&usual.time_ns) {
        off += usize::from(((a - b) as f64 * 1e-9 - offset).abs() > 0.012);
    }
    assert!(off * 20 < count, "{off} of {count} are off");
    noted(&found, &["speed", "bursts of 5 to 5"]);
}

#[test]
fn a_second_publisher_is_left_out_where_the_feedback_decides_and_refused_where_it_does_not() {
    let second = |with_feedback: bool| {
        let mut count = 0;
        read(changed(move |entry| {
            if entry.topic != COMMAND {
                return if entry.topic == FEEDBACK && !with_feedback { Vec::new() } else { vec![entry] };
            }
            count += 1;
            let mut idle = entry.clone();
            idle.set_value(0.0);
            (idle.log_ns, idle.publish_ns) = (idle.log_ns + SECOND / 200, idle.publish_ns + SECOND / 200);
            if count % 5 == 0 { vec![entry, idle] } else { vec![entry] }
        }))
    };
    let found = second(true);
    let track = Track::new(&found).unwrap();
    assert!(track.notes.iter().any(|note| note.contains("two publishers")), "{:?}", track.notes);
    let apart = apart_mps2(&fitted(&found), &fitted(&usual()));
    assert!(apart < 0.01, "{apart}");
    let error = Track::new(&second(false)).unwrap_err().to_string();
    assert!(error.contains("two publishers") && error.contains("0 N·m"), "{error}");
}

#[test]
fn a_torque_that_was_recorded_late_is_moved_onto_the_motion() {
    let late = read(changed(|mut entry| {
        if entry.topic == COMMAND || entry.topic == FEEDBACK {
            (entry.log_ns, entry.publish_ns) = (entry.log_ns + 2 * SECOND, entry.publish_ns + 2 * SECOND);
        }
        vec![entry]
    }));
    let track = Track::new(&late).unwrap();
    assert!(track.notes.iter().any(|note| note.contains("so that the motion follows it")), "{:?}", track.notes);
    let apart = apart_mps2(&fitted(&late), &fitted(&usual()));
    assert!(apart < 0.01, "{apart}");
}

#[test]
fn a_reversed_sign_is_reported_as_one() {
    let map = |speed: &str, torque: &str| {
        let text = format!(
            "[vehicle]\nwheelbase_m = 0.9\nwheel_radius_m = 0.12\n[signals]\nspeed = {{ path = '/joint_states.velocity{{name==\"front_drive_joint\"}}', unit = 'rad/s', {speed} }}\n\
             torque = {{ path = '/drive/torque_command.data', {torque} }}\nangle = {{ path = '/eps/joint_states.position{{name==\"front_steer_joint\"}}' }}\n\
             gear = {{ path = '/drive/gear.data', neutral = 0, forward = 1, reverse = 2 }}\n"
        );
        let source = Source::Map(SignalMap::from_toml(&text).unwrap());
        read_bytes(LOG.clone(), "drive.mcap", &source, &VehicleOverrides::default()).map(|recording| Track::new(&recording))
    };
    assert!(map("stamp = 'none'", "scale = 1").unwrap().is_ok());
    let error = map("scale = -1", "scale = 1").unwrap().unwrap_err().to_string();
    assert!(error.contains("speed contradicts the gear") && error.contains("scale = -1"), "{error}");
    let error = map("scale = 1", "scale = -1").unwrap().unwrap_err().to_string();
    assert!(error.contains("opposite signs"), "{error}");
    let error = map("stamp = 'header.stmp'", "scale = 1").unwrap_err().to_string();
    assert!(error.contains("header.stmp") && error.contains("the nearest is header.stamp"), "{error}");
}

#[test]
fn the_ledger_adds_up_to_the_length_of_the_log() {
    let survey = Survey::new(Track::new(&usual()).unwrap(), &SurveySettings::default()).unwrap();
    let rows = with_missing(ledger(survey.verdicts.iter().copied().zip(survey.seconds.iter().copied())), survey.missing_s());
    let sum: f64 = rows.iter().map(|row| row.seconds).sum();
    let times = &survey.track.encoder_mps.t_s;
    assert!((sum - (times[times.len() - 1] - times[0])).abs() < 0.05, "{sum}");
}
