//! The signals of one log on one clock, in the vehicle's frame.

use crate::log::{Recording, Signal};
use crate::map::{LogRef, Vehicle};
use crate::signal::agreement::{NEAR_ANGLE_RAD, Sources};
use crate::signal::stuck::expect_changes;
use crate::signal::taken::{FEWEST, TakenSignals};
use crate::signal::{Error, Result, Series, resolve};
use crate::units::RAD_PER_DEG;

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
    /// Uncertainty of each time of the command, apart from an offset of all of them [s].
    pub command_std_s: f64,
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
    /// A required signal has too few values, the speed or the yaw rate never changes, a sign cannot be determined or is reversed, two publishers command the torque, or signals do not
    /// overlap in time.
    pub fn new(recording: &Recording) -> Result<Self> {
        Self::at_angle(recording, recording.vehicle.test_angle_deg)
    }

    /// The same for runs at a wheel angle [°].
    ///
    /// # Errors
    /// As [`Track::new`].
    pub fn at_angle(recording: &Recording, wheel_angle_deg: f64) -> Result<Self> {
        let signals = &recording.signals;
        expect_changes(recording)?;
        let mut taken = TakenSignals::new(recording);
        let gear = signals.gear.as_ref().map(|s| taken.held("gear", s)).filter(|s| !s.is_empty());
        let estop = signals.estop.as_ref().map(|s| taken.held("estop", s)).filter(|s| !s.is_empty());
        let mut encoder_mps = taken.measured("speed", &signals.speed);
        if encoder_mps.len() < FEWEST {
            return Err(Error::TooFew { signal: "speed", found: encoder_mps.len(), needed: FEWEST });
        }
        let mut feedback_nm = taken.optional("torque_feedback", signals.torque_feedback.as_ref());
        // ω = v·sin δ / L, hence v = L·ω / sin δ
        let lever_m = recording.vehicle.wheelbase_m / (wheel_angle_deg * RAD_PER_DEG).sin();
        let has_lever = lever_m.is_finite() && lever_m.abs() < 10.0 * recording.vehicle.wheelbase_m;
        let mut yaw_speed_mps = taken.optional("yaw_rate", signals.yaw_rate.as_ref().filter(|_| has_lever)).map(|mut s| {
            s.value.iter_mut().for_each(|v| *v *= lever_m);
            s
        });
        let mut angle_rad = taken.held("angle", &signals.angle);
        taken.enough("angle", &signals.angle)?;
        if let (1, Some(yaw)) = (signals.angle.len(), &yaw_speed_mps) {
            // a latched angle may have been published before the wheel was steered
            let wheel_angle_rad = wheel_angle_deg * RAD_PER_DEG;
            let sources = Sources { encoder_mps: &encoder_mps, gear: gear.as_ref(), angle_rad: &angle_rad, wheel_angle_rad };
            if (angle_rad.value[0] - wheel_angle_rad).abs() > NEAR_ANGLE_RAD && sources.yaw_shows_angle(yaw) {
                taken.notes.push(format!(
                    "angle is logged once, as {:.1}°, but the yaw rate shows that the runs were driven at {wheel_angle_deg}°: that angle is used",
                    angle_rad.value[0] / RAD_PER_DEG
                ));
                angle_rad.value.fill(wheel_angle_rad);
            }
        }
        let mut command_nm = taken.command(feedback_nm.as_ref())?;
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
        let wheel_angle_rad = wheel_angle_deg * RAD_PER_DEG;
        let sources = Sources { encoder_mps: &encoder_mps, gear: gear.as_ref(), angle_rad: &angle_rad, wheel_angle_rad };
        sources.onto_one_clock(&mut command_nm, feedback_nm.as_mut(), yaw_speed_mps.as_mut(), &mut taken.notes);
        sources.check_signs(&command_nm, yaw_speed_mps.as_ref())?;
        let track = Self {
            source: recording.source.clone(),
            vehicle: recording.vehicle,
            wheel_angle_deg,
            start_ns: taken.start_ns,
            encoder_mps,
            yaw_speed_mps,
            command_nm,
            command_std_s: signals.torque.time_std_s,
            feedback_nm,
            angle_rad,
            gear,
            estop,
            notes: taken.notes,
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
