//! The signals of one log on one clock, in the vehicle's frame.

use crate::log::{MessageKind, Recording, Signal, rate};
use crate::map::{LogRef, Vehicle};
use crate::signal::held::{held_note, held_until};
use crate::signal::{Error, Result, Series, new_values_only, resolve};
use crate::units::{NS_PER_S, RAD_PER_DEG};

/// Smallest number of values of a measured signal.
const FEWEST: usize = 50;
/// Smallest number of commands that hold until the next one: a step and what was before it.
const FEWEST_HELD: usize = 2;

/// The signals of one log: seconds since its first sample, SI, signs resolved (forward positive, left positive).
#[derive(Debug, Clone)]
pub struct Track {
    /// The log.
    pub source: LogRef,
    /// The vehicle.
    pub vehicle: Vehicle,
    /// The wheel angle of the wanted runs [°], left positive.
    pub wheel_angle_deg: f64,
    /// Time 0 of every series here [ns].
    pub start_ns: i64,
    /// Front-wheel speed from its encoder [m/s].
    pub encoder_mps: Series,
    /// Front-wheel speed from the yaw rate, L·θ̇ / sin δ [m/s], with the wheel angle δ of the runs; valid only there.
    pub yaw_speed_mps: Option<Series>,
    /// Torque command [N·m], held between its samples.
    pub command_nm: Series,
    /// Torque feedback [N·m].
    pub feedback_nm: Option<Series>,
    /// Wheel angle [rad].
    pub angle_rad: Series,
    /// Gear: −1, 0, 1.
    pub gear: Option<Series>,
    /// Emergency stop: 0, 1.
    pub estop: Option<Series>,
    /// Notes for the reader: values repeated at a fast rate, ignored signals.
    pub notes: Vec<String>,
}

impl Track {
    /// The track of one log, for runs at the vehicle's test angle.
    ///
    /// # Errors
    /// A required signal has fewer than 50 values, a sign cannot be determined, or signals do not overlap in time.
    pub fn new(recording: &Recording) -> Result<Self> {
        Self::at_angle(recording, recording.vehicle.test_angle_deg)
    }

    /// The same for runs at a wheel angle [°].
    ///
    /// # Errors
    /// As [`Track::new`].
    pub fn at_angle(recording: &Recording, wheel_angle_deg: f64) -> Result<Self> {
        let signals = &recording.signals;
        let optional = [&signals.torque_feedback, &signals.yaw_rate, &signals.gear, &signals.estop];
        let start_ns = [&signals.speed, &signals.torque, &signals.angle]
            .into_iter()
            .chain(optional.into_iter().flatten())
            .filter_map(|s| s.time_ns.first().copied())
            .min()
            .unwrap_or(0);
        let mut notes = recording.clock_notes.clone();
        let speed_end_ns = signals.speed.time_ns.last().copied().unwrap_or(start_ns);
        let end_s = speed_end_ns.saturating_sub(start_ns) as f64 / NS_PER_S;
        let mut take = |name: &'static str, signal: &Signal, dedupe: bool| {
            let series = Series {
                t_s: signal.time_ns.iter().map(|t| t.saturating_sub(start_ns) as f64 / NS_PER_S).collect(),
                value: signal.value.clone(),
            };
            let kind = MessageKind::of(&series.t_s, &series.value);
            if kind.is_held() {
                notes.extend(held_note(name, kind, &series));
                return held_until(&series, end_s);
            }
            match rate(signal) {
                Some(rate) if dedupe && rate.repeats > 1 => {
                    notes.push(format!(
                        "{name}: logged at {:.0} Hz, but new values come only at {:.1} Hz; repeated values are left out",
                        rate.logged_hz, rate.true_hz
                    ));
                    new_values_only(&series, rate.repeats)
                }
                _ => series,
            }
        };
        let gear = signals.gear.as_ref().map(|s| take("gear", s, false)).filter(|s| !s.is_empty());
        let estop = signals.estop.as_ref().map(|s| take("estop", s, false)).filter(|s| !s.is_empty());
        let mut encoder_mps = take("speed", &signals.speed, true);
        let mut command_nm = take("torque", &signals.torque, false);
        let feedback_nm = signals.torque_feedback.as_ref().map(|s| take("torque_feedback", s, true));
        let angle_rad = take("angle", &signals.angle, false);
        // ω = v·sin δ / L, hence v = L·ω / sin δ
        let lever_m = recording.vehicle.wheelbase_m / (wheel_angle_deg * RAD_PER_DEG).sin();
        let yaw_speed_mps = signals
            .yaw_rate
            .as_ref()
            .filter(|_| lever_m.is_finite() && lever_m.abs() < 10.0 * recording.vehicle.wheelbase_m)
            .map(|s| take("yaw_rate", s, true));
        let mut feedback_nm = enough("torque_feedback", feedback_nm, &mut notes);
        let yaw_speed_mps = enough("yaw_rate", yaw_speed_mps, &mut notes).map(|mut s| {
            s.value.iter_mut().for_each(|v| *v *= lever_m);
            s
        });
        // a command or an angle may hold for a long time; a speed is measured
        for (signal, series, found, needed) in [
            ("speed", &encoder_mps, signals.speed.len(), FEWEST),
            ("torque", &command_nm, signals.torque.len(), FEWEST_HELD),
            ("angle", &angle_rad, signals.angle.len(), 1),
        ] {
            let is_filled = series.len() > found;
            if found.min(series.len()) < if is_filled || signal == "speed" { needed } else { FEWEST } {
                return Err(Error::TooFew { signal, found, needed });
            }
        }
        let relative = |signal: Option<&Signal>| signal.is_some_and(|s| s.relative_to_gear);
        if relative(Some(&signals.torque)) {
            resolve::relative_to_gear("torque", &mut command_nm, gear.as_ref())?;
        }
        if let Some(feedback) = feedback_nm.as_mut().filter(|_| relative(signals.torque_feedback.as_ref())) {
            resolve::relative_to_gear("torque_feedback", feedback, gear.as_ref())?;
        }
        if relative(Some(&signals.speed)) {
            resolve::relative_to_gear("speed", &mut encoder_mps, gear.as_ref())?;
        }
        if signals.speed.unsigned {
            resolve::signed("speed", &mut encoder_mps, gear.as_ref(), yaw_speed_mps.as_ref())?;
        }
        if signals.torque.unsigned {
            resolve::signed("torque", &mut command_nm, gear.as_ref(), None)?;
        }
        let track = Self {
            source: recording.source.clone(),
            vehicle: recording.vehicle,
            wheel_angle_deg,
            start_ns,
            encoder_mps,
            yaw_speed_mps,
            command_nm,
            feedback_nm,
            angle_rad,
            gear,
            estop,
            notes,
        };
        track.check_overlap()?;
        Ok(track)
    }

    fn check_overlap(&self) -> Result<()> {
        let ends = |s: &Series| (s.t_s[0], s.t_s[s.len() - 1]);
        let (speed_from_s, speed_to_s) = ends(&self.encoder_mps);
        for (signal, series) in [("torque", &self.command_nm), ("angle", &self.angle_rad)] {
            let (from_s, to_s) = ends(series);
            if from_s > speed_to_s || to_s < speed_from_s {
                return Err(Error::NoOverlap { signal, from_s, to_s, speed_from_s, speed_to_s });
            }
        }
        Ok(())
    }

    /// The speed sources: the encoder, and the yaw rate if it is logged.
    pub fn witnesses(&self) -> impl Iterator<Item = &Series> {
        std::iter::once(&self.encoder_mps).chain(self.yaw_speed_mps.as_ref())
    }
}

/// A signal that is not required, if it has enough values; otherwise a note.
fn enough(signal: &str, series: Option<Series>, notes: &mut Vec<String>) -> Option<Series> {
    let found = series.as_ref()?.len();
    if found < FEWEST {
        notes.push(format!("{signal} is not used: it has {found} usable values, at least {FEWEST} are needed"));
    }
    series.filter(|s| s.len() >= FEWEST)
}
