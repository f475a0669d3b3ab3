//! Reads a recording that was split into several files as one, so that a run across a file border is complete.

use crate::log::find::infer_units;
use crate::log::loss::Loss;
use crate::log::read::RecordingPart;
use crate::log::recording::{Recording, Signal};
use crate::log::signal_map::{SignalName, VehicleOverrides};
use crate::log::timing::log_clock::{ClockStep, LEAST_STEP_NS};
use crate::log::timing::message_times::SignalTimes;
use crate::log::timing::true_times;
use crate::log::{Error, Result, Source, read};
use crate::map::LogRef;
use crate::text::shown;
use sha2::{Digest, Sha256};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Reads the signals `wanted` from the files of one recording, in their order, as one log. A file without a required signal, or without any message, is skipped with
/// a note, as long as another file has it. The hash of several files is the hash of their concatenated hashes in hexadecimal. `progress` is
/// as in [`crate::log::read`].
///
/// # Errors
/// As [`crate::log::read`]; the first error, if no file can be used.
pub(crate) fn read_split(
    paths: &[PathBuf],
    wanted: &[SignalName],
    source: &Source,
    overrides: &VehicleOverrides,
    progress: &(dyn Fn(u64) + Sync),
) -> Result<Recording> {
    let mut overrides = *overrides;
    let mut whole: Option<RecordingPart> = None;
    let mut skipped = Vec::new();
    let mut first_error = None;
    for path in paths {
        let next = match read::part(path, true, wanted, source, &overrides, progress) {
            Ok(next) => next,
            Err(error @ (Error::NoMessages { .. } | Error::NoValues { .. } | Error::NoTopic { .. } | Error::MissingSignal { .. }))
                if paths.len() > 1 =>
            {
                let file = shown(path.file_name().unwrap_or_default());
                skipped.push(format!("{file} is skipped: {error}"));
                first_error.get_or_insert(error);
                continue;
            }
            Err(error) => return Err(error),
        };
        // one recording has one vehicle; its writer may have described it in one file only
        let vehicle = next.recording.vehicle;
        overrides = VehicleOverrides {
            wheelbase_m: Some(vehicle.wheelbase_m),
            wheel_radius_m: Some(vehicle.wheel_radius_m),
            test_angle_deg: Some(vehicle.test_angle_deg),
            torque_limit_nm: vehicle.torque_limit_nm,
            torque_full_scale_nm: vehicle.torque_full_scale_nm,
        };
        match &mut whole {
            None => whole = Some(next),
            Some(whole) => whole.append(next),
        }
    }
    let Some(mut whole) = whole else {
        return Err(first_error.unwrap_or(Error::NoLogs));
    };
    if whole.files > 1 {
        let hash = Sha256::digest(&whole.recording.source.sha256);
        whole.recording.source.sha256 = hash.iter().fold(String::with_capacity(64), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        });
    }
    whole.recording.notes.extend(skipped);
    Ok(whole.finish())
}

impl RecordingPart {
    /// Adds the next file of the same recording.
    fn append(&mut self, next: Self) {
        self.append_clock(&next);
        self.files += 1;
        self.guessed |= next.guessed;
        self.unnamed.extend(next.unnamed);
        let next_times = next.times;
        let (whole, next) = (&mut self.recording, next.recording);
        let LogRef { sha256, file, bytes, .. } = next.source;
        whole.source.sha256 += &sha256;
        whole.source.bytes += bytes;
        let first = whole.source.file.split(" … ").next().unwrap_or_default();
        whole.source.file = format!("{first} … {file}");
        for (name, times) in next_times {
            let Some(more) = next.signals.get(name) else { continue };
            let mut signal = whole.signals.get(name).cloned().unwrap_or_default();
            signal.append(more);
            whole.signals.set(name, signal);
            self.times.entry(name).or_default().extend(times);
        }
        for origin in next.origins {
            match whole.origins.iter_mut().find(|known| known.signal == origin.signal && known.path == origin.path) {
                Some(known) => known.values += origin.values,
                None => whole.origins.push(origin),
            }
        }
        whole.loss.append(next.loss);
        for note in next.notes {
            if !whole.notes.contains(&note) {
                whole.notes.push(note);
            }
        }
    }

    /// Adds the steps of the recorder's clock; the values of both parts are counted in the order of all their names.
    fn append_clock(&mut self, next: &Self) {
        let mut names: Vec<SignalName> = self.times.keys().chain(next.times.keys()).copied().collect();
        names.sort_unstable();
        names.dedup();
        let spread = |step: &ClockStep, part: &Self| {
            let of = |name: &SignalName| part.times.keys().position(|known| known == name).and_then(|at| step.values.get(at)).copied();
            ClockStep { values: names.iter().map(|name| of(name).unwrap_or(0)).collect(), ..step.clone() }
        };
        let so_far: Vec<usize> = names.iter().map(|name| self.times.get(name).map_or(0, Vec::len)).collect();
        let mut steps: Vec<ClockStep> = self.clock_steps.iter().map(|step| spread(step, self)).collect();
        if let Some(((first, latest), (next_first, next_latest))) = self.span_ns.zip(next.span_ns) {
            if next_first < latest.saturating_sub(LEAST_STEP_NS) {
                steps.push(ClockStep { before_ns: latest, after_ns: next_first, values: so_far.clone() });
            }
            self.span_ns = Some((first, next_latest));
        } else {
            self.span_ns = self.span_ns.or(next.span_ns);
        }
        steps.extend(next.clock_steps.iter().map(|step| spread(step, next).after(&so_far)));
        self.clock_steps = steps;
    }

    /// The recording, with the true times of its signals, and with units and signs corrected from the values.
    pub(crate) fn finish(self) -> Recording {
        let mut recording = self.recording;
        let signals: Vec<SignalTimes> = self.times.iter().map(|(signal, times)| SignalTimes { signal: *signal, times }).collect();
        let (true_times, clock_notes) = true_times(&signals, &self.clock_steps);
        recording.clock_notes = clock_notes;
        recording.source.loss = recording.loss.reported();
        for (name, times) in self.times.keys().zip(true_times) {
            let mut signal = recording.signals.get(*name).cloned().unwrap_or_default();
            (signal.time_ns, signal.time_std_s) = (times.time_ns, times.std_s);
            signal.sort();
            recording.signals.set(*name, signal);
        }
        if self.guessed {
            recording.notes.extend(infer_units::correct(&mut recording.signals, &recording.vehicle, &self.unnamed));
        }
        recording
    }
}

impl Signal {
    /// Adds values that were logged later; their times are found for the whole recording.
    fn append(&mut self, next: &Self) {
        self.relative_to_gear |= next.relative_to_gear;
        self.unsigned |= next.unsigned;
        self.value.extend(&next.value);
    }
}

impl Loss {
    /// Adds the read and lost data of the next file. Places keep their position in their own file.
    fn append(&mut self, next: Self) {
        self.messages_read += next.messages_read;
        self.messages_lost = self.messages_lost.zip(next.messages_lost).map(|(a, b)| a + b);
        self.bytes_lost += next.bytes_lost;
        self.places.extend(next.places);
        for (topic, count) in next.broken_messages {
            *self.broken_messages.entry(topic).or_default() += count;
        }
        for (signal, count) in next.not_finite {
            *self.not_finite.entry(signal).or_default() += count;
        }
    }
}
