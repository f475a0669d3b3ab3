//! Brings the signals of a log into agreement: their clocks and their signs.

use crate::signal::clock_check::{feedback_offset_s, moved, torque_offset_s, yaw_offset_s};
use crate::signal::response::Accelerations;
use crate::signal::signs::{check_direction, check_torque};
use crate::signal::{Result, Series, median};

/// The signals with which others are compared.
pub(crate) struct Sources<'a> {
    pub encoder_mps: &'a Series,
    pub gear: Option<&'a Series>,
    pub angle_rad: &'a Series,
    /// The wheel angle of the runs, where the yaw rate gives the wheel's speed [rad].
    pub wheel_angle_rad: f64,
}

/// Distance from the wheel angle within which the yaw rate is compared with the wheel [rad].
pub(crate) const NEAR_ANGLE_RAD: f64 = 0.09;
/// Largest difference of encoder and yaw rate, as a share, by which the yaw rate shows the wheel angle.
const SHOWS_ANGLE: f64 = 0.1;
/// Lowest speed at which they are compared [m/s], and fewest readings.
const CLEAR_MPS: f64 = 0.1;
const FEWEST_READINGS: usize = 100;

impl Sources<'_> {
    /// Whether the wheel is at the angle of the runs at a time.
    fn is_at_angle(&self, t_s: f64) -> bool {
        self.angle_rad.held(t_s).is_some_and(|a| (a - self.wheel_angle_rad).abs() <= NEAR_ANGLE_RAD)
    }

    /// Whether the yaw rate shows that the wheel stands at the angle of the runs, whatever the angle's own signal is.
    pub(crate) fn yaw_shows_angle(&self, yaw: &Series) -> bool {
        let mut along = yaw.cursor();
        let moving = self.encoder_mps.t_s.iter().zip(&self.encoder_mps.value).filter(|(_, v)| v.abs() > CLEAR_MPS);
        let ratios: Vec<f64> = moving.filter_map(|(t, v)| Some(along.interpolated(*t)? / v)).collect();
        ratios.len() >= FEWEST_READINGS && (median(&ratios) - 1.0).abs() < SHOWS_ANGLE
    }

    /// Moves signals that are clearly on another clock, with a note on each.
    pub(crate) fn onto_one_clock(
        &self,
        command: &mut Series,
        feedback: Option<&mut Series>,
        yaw: Option<&mut Series>,
        notes: &mut Vec<String>,
    ) {
        if let Some(yaw) = yaw
            && let Some(offset_s) = yaw_offset_s(self.encoder_mps, yaw, |t| self.is_at_angle(t))
        {
            moved(yaw, offset_s);
            notes.push(format!("yaw_rate is on another clock: it was moved by {offset_s:+.2} s to agree with the speed"));
        }
        let mut own_s = None;
        if let Some(feedback) = &feedback {
            own_s = feedback_offset_s(command, feedback);
        }
        let torque_s = Accelerations::of(self.encoder_mps).and_then(|motion| torque_offset_s(command, &motion));
        if let Some(offset_s) = torque_s {
            moved(command, offset_s);
            notes.push(format!(
                "torque is on another clock: it was moved by {offset_s:+.2} s so that the motion follows it; dead time and clock offset cannot be \
                 separated"
            ));
        }
        let feedback_s = own_s.unwrap_or(0.0) + torque_s.unwrap_or(0.0);
        if let Some(feedback) = feedback.filter(|_| feedback_s != 0.0) {
            moved(feedback, feedback_s);
            if own_s.is_some() {
                notes.push(format!("torque_feedback is on another clock: it was moved by {feedback_s:+.2} s to agree with the command"));
            }
        }
    }

    /// Checks signs that must agree.
    ///
    /// # Errors
    /// One is reversed.
    pub(crate) fn check_signs(&self, command: &Series, yaw: Option<&Series>) -> Result<()> {
        check_direction(self.encoder_mps, self.gear, yaw, |t| self.is_at_angle(t))?;
        Accelerations::of(self.encoder_mps).map_or(Ok(()), |motion| check_torque(command, &motion))
    }
}
