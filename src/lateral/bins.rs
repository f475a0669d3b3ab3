//! e = cos θ·(y_m − y) − sin θ·(x_m − x): the lateral error at every matched point of a log, averaged over pieces of the path.
//!
//! The matched points are logged, or found on the logged reference path.
//!
//! Distance is that of the matched point along its path, so that runs of one task can be compared piece by piece. The settling distance
//! after a start or a standstill is left out: there the tracking law is still steering the vehicle onto the path.

use crate::lateral::nearest::NearestPoint;
use crate::lateral::settings::LateralFitSettings;
use crate::lateral::{Error, Result};
use crate::log::{Recording, Signal, SignalName};
use crate::units::{NS_PER_S, RAD_PER_DEG};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A piece of the path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Bin {
    /// Sum of the errors [m].
    pub sum_m: f64,
    /// Number of errors.
    pub count: f64,
}

impl Bin {
    /// Mean error [m].
    pub(crate) fn mean_m(&self) -> f64 {
        self.sum_m / self.count
    }
}

/// One run of the calibration.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct CompensationRun {
    /// File name of its log.
    pub log: String,
    /// Compensation angle [rad]; 0 for the base.
    pub angle_rad: f64,
    /// Distance of the whole run [m].
    pub way_m: f64,
    /// The counted pieces of the path, by number.
    pub bins: BTreeMap<u32, Bin>,
}

/// Longest gap between readings that are joined [s].
const GAP_S: f64 = 0.3;
/// Smallest distance that counts as a move of the matched point [m]: well above the noise of a pose.
const MOVED_M: f64 = 0.05;
/// A standstill of this length ends an interval [s].
const STANDING_S: f64 = 1.0;
/// Largest spread of a compensation angle that counts as one angle [rad].
const ONE_ANGLE_RAD: f64 = 0.02 * RAD_PER_DEG;
/// Smallest number of matched points of a log.
const LEAST: usize = 50;

impl CompensationRun {
    /// The run of a recording that was read for the lateral calibration.
    ///
    /// # Errors
    /// There is no heading, the signals do not overlap, or the compensation changes.
    pub(crate) fn new(recording: &Recording, settings: &LateralFitSettings) -> Result<Self> {
        let log = recording.source.file.clone();
        let heading = heading(recording).ok_or_else(|| Error::NoHeading { log: log.clone() })?;
        let paths = &recording.signals.reference_paths;
        if !paths.is_empty() && paths.iter().all(|path| path.points_m.len() < 2) {
            return Err(Error::NoPath { log, found: paths.len() });
        }
        let errors = if paths.is_empty() { from_points(recording, &heading) } else { from_paths(recording, &heading) };
        if errors.len() < LEAST {
            return Err(Error::NoOverlap { log, found: errors.len(), needed: LEAST });
        }
        let angle_rad = angle(recording.signals.lateral.get(&SignalName::Compensation), &log)?;
        let (way_m, bins) = binned(&errors, settings);
        Ok(Self { log, angle_rad, way_m, bins })
    }
}

/// Time, matched point and error of one place.
type PathPlace = (i64, f64, f64, f64);

fn place(time_ns: i64, [x_m, y_m]: [f64; 2], [x, y, yaw_rad]: [f64; 3]) -> PathPlace {
    let (sin, cos) = yaw_rad.sin_cos();
    (time_ns, x_m, y_m, cos * (y_m - y) - sin * (x_m - x))
}

/// Errors at every logged matched point, with the interpolated pose.
fn from_points(recording: &Recording, heading: &Signal) -> Vec<PathPlace> {
    let none = Signal::default();
    let read = |name| recording.signals.lateral.get(&name).unwrap_or(&none);
    let (x, y) = (read(SignalName::PoseX), read(SignalName::PoseY));
    let (reference_x, reference_y) = (read(SignalName::ReferenceX), read(SignalName::ReferenceY));
    let mut cursors = [PathCursor::default(); 4];
    let places = reference_x.time_ns.iter().zip(&reference_x.value).filter_map(|(&time_ns, &x_m)| {
        let [c0, c1, c2, c3] = &mut cursors;
        let y_m = c0.at(reference_y, time_ns, false)?;
        Some(place(time_ns, [x_m, y_m], [c1.at(x, time_ns, false)?, c2.at(y, time_ns, false)?, c3.at(heading, time_ns, true)?]))
    });
    places.collect()
}

/// Errors at every pose, to the nearest point of the current path.
fn from_paths(recording: &Recording, heading: &Signal) -> Vec<PathPlace> {
    let none = Signal::default();
    let read = |name| recording.signals.lateral.get(&name).unwrap_or(&none);
    let (x, y) = (read(SignalName::PoseX), read(SignalName::PoseY));
    let mut nearest = NearestPoint::new(&recording.signals.reference_paths);
    let mut cursors = [PathCursor::default(); 2];
    let places = x.time_ns.iter().zip(&x.value).filter_map(|(&time_ns, &x_m)| {
        let [c0, c1] = &mut cursors;
        let (y_m, yaw_rad) = (c0.at(y, time_ns, false)?, c1.at(heading, time_ns, true)?);
        Some(place(time_ns, nearest.at(time_ns, [x_m, y_m], yaw_rad)?, [x_m, y_m, yaw_rad]))
    });
    places.collect()
}

/// The heading: logged, or θ = 2·atan2(z, w) from its quaternion on level ground.
fn heading(recording: &Recording) -> Option<Signal> {
    let signals = &recording.signals.lateral;
    if let Some(yaw) = signals.get(&SignalName::Yaw) {
        return Some(yaw.clone());
    }
    let (z, w) = (signals.get(&SignalName::YawZ)?, signals.get(&SignalName::YawW)?);
    let mut cursor = PathCursor::default();
    let mut yaw = Signal::default();
    for (&time_ns, &z) in z.time_ns.iter().zip(&z.value) {
        if let Some(w) = cursor.at(w, time_ns, false) {
            yaw.time_ns.push(time_ns);
            yaw.value.push(2.0 * z.atan2(w));
        }
    }
    Some(yaw)
}

/// The run's angle: the median, if all values agree with it; 0 without the signal.
fn angle(signal: Option<&Signal>, log: &str) -> Result<f64> {
    let Some(signal) = signal.filter(|s| !s.is_empty()) else { return Ok(0.0) };
    let mut values = signal.value.clone();
    values.sort_by(f64::total_cmp);
    let (low, high) = (values[0], values[values.len() - 1]);
    if high - low > ONE_ANGLE_RAD {
        return Err(Error::Changing { log: log.to_owned(), low_deg: low / RAD_PER_DEG, high_deg: high / RAD_PER_DEG });
    }
    Ok(values[values.len() / 2])
}

/// Total distance, and the counted pieces.
fn binned(errors: &[PathPlace], settings: &LateralFitSettings) -> (f64, BTreeMap<u32, Bin>) {
    let mut bins: BTreeMap<u32, Bin> = BTreeMap::new();
    let (mut way_m, mut since_start_m) = (0.0, 0.0);
    let mut pending = Bin::default();
    let (mut last_ns, mut last_x, mut last_y) = (errors[0].0, errors[0].1, errors[0].2);
    for &(time_ns, x_m, y_m, error_m) in errors {
        pending.sum_m += error_m;
        pending.count += 1.0;
        let moved_m = f64::hypot(x_m - last_x, y_m - last_y);
        if moved_m < MOVED_M {
            continue;
        }
        if (time_ns - last_ns) as f64 / NS_PER_S > STANDING_S {
            since_start_m = 0.0;
        } else if since_start_m >= settings.settle_m {
            let bin = bins.entry((way_m / settings.piece_m) as u32).or_default();
            bin.sum_m += pending.sum_m;
            bin.count += pending.count;
        }
        way_m += moved_m;
        since_start_m += moved_m;
        (pending, last_ns, last_x, last_y) = (Bin::default(), time_ns, x_m, y_m);
    }
    (way_m, bins)
}

/// Reads a signal at ascending times.
#[derive(Debug, Clone, Copy, Default)]
struct PathCursor {
    next: usize,
}

impl PathCursor {
    /// Linear interpolation at `time_ns`; `None` outside the readings or in a gap. `circular`: an angle, interpolated along the shorter
    /// arc.
    fn at(&mut self, signal: &Signal, time_ns: i64, circular: bool) -> Option<f64> {
        let (times, values) = (&signal.time_ns, &signal.value);
        while self.next < times.len() && times[self.next] < time_ns {
            self.next += 1;
        }
        let after = self.next;
        if times.get(after) == Some(&time_ns) {
            return Some(values[after]);
        }
        let before = after.checked_sub(1)?;
        let (t0, t1) = (times[before], *times.get(after)?);
        let span = (t1 - t0) as f64;
        if span > GAP_S * NS_PER_S {
            return None;
        }
        let mut change = values[after] - values[before];
        if circular {
            change = (change + PI).rem_euclid(TAU) - PI;
        }
        Some(values[before] + (time_ns - t0) as f64 / span * change)
    }
}
