//! The effective torque by the drive's own feedback.
//!
//! Piecewise linear between the readings, which are not smoothed: the integral averages their noise, and means over
//! neighbours would round the corners. (Means of three left 2 to 6 times the torque error at 25 Hz behind a limit of 150 or 300 N·m/s, and
//! were no better at 100 Hz.) The dead time is the delay from feedback to speed, and ∂u/∂T_d = −u̇.

use crate::fit::drive::lagged_command::{LaggedCommand, Share};
use crate::fit::drive_form::torque::Torque;
use crate::signal::Series;

/// Between readings further apart than this the torque is unknown [s]: one or two lost readings are bridged.
const LONGEST_GAP_S: f64 = 0.13;
/// The torque moves between two readings when it changes by more than this share of the largest torque: more than noise does.
const MOVING: f64 = 0.01;

/// The torque feedback of one log, for look-ups at any time.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredTorque {
    t_s: Vec<f64>,
    torque_nm: Vec<f64>,
    /// Where the torque is unknown [s], both ends of the log included.
    gaps: Vec<(f64, f64)>,
    command: LaggedCommand,
    late_s: f64,
}

/// A position in a measured torque that moves along with time.
#[derive(Debug, Clone)]
pub(crate) struct MeasuredCursor<'a> {
    measured: &'a MeasuredTorque,
    /// Number of readings at or before the time of the last look-up.
    passed: usize,
}

impl MeasuredCursor<'_> {
    /// As [`MeasuredTorque::at`].
    pub(crate) fn at(&mut self, t_s: f64) -> Torque {
        let times = &self.measured.t_s;
        while times.get(self.passed).is_some_and(|&t| t <= t_s) {
            self.passed += 1;
        }
        while self.passed > 0 && times[self.passed - 1] > t_s {
            self.passed -= 1;
        }
        self.measured.after(self.passed, t_s)
    }

    /// Whether the torque moves by more than `share` of the largest, and more than its noise, between two times, in order.
    pub(crate) fn moves(&mut self, from_s: f64, to_s: f64, share: Share) -> bool {
        let from = self.at(from_s);
        let mut ahead = self.clone();
        (ahead.at(to_s).torque_nm - from.torque_nm).abs() > share.value.max(MOVING) * self.measured.largest_nm()
    }
}

impl MeasuredTorque {
    /// From a feedback with at least one reading; it shows a step `late_s` later than the command.
    pub(crate) fn new(command: &Series, feedback: &Series, late_s: f64) -> Self {
        Self {
            torque_nm: feedback.value.clone(),
            t_s: feedback.t_s.clone(),
            gaps: gaps(feedback),
            command: LaggedCommand::new(command, 0.0),
            late_s,
        }
    }

    /// Effective torque at `t_s` on the feedback's clock: pass t − T_d. The first and last readings are held beyond the ends.
    pub(crate) fn at(&self, t_s: f64) -> Torque {
        self.after(self.t_s.partition_point(|&t| t <= t_s), t_s)
    }

    /// A cursor at the beginning.
    pub(crate) fn cursor(&self) -> MeasuredCursor<'_> {
        MeasuredCursor { measured: self, passed: 0 }
    }

    /// Torque at a time after `k` readings.
    fn after(&self, k: usize, t_s: f64) -> Torque {
        if k == 0 || k == self.t_s.len() {
            let end = self.torque_nm.get(k.saturating_sub(1)).copied().unwrap_or(0.0);
            return Torque::constant(end);
        }
        let (t0, u0) = (self.t_s[k - 1], self.torque_nm[k - 1]);
        let slope = (self.torque_nm[k] - u0) / (self.t_s[k] - t0).max(1e-9);
        Torque { by_dead_time: -slope, ..Torque::constant(u0 + slope * (t_s - t0)) }
    }

    /// Largest torque commanded [N·m].
    pub(crate) fn largest_nm(&self) -> f64 {
        self.command.largest_nm()
    }

    /// Times at which the feedback begins to show that the command changed by more than `least_nm` [s].
    pub(crate) fn steps(&self, least_nm: f64) -> Vec<f64> {
        self.command.steps(least_nm).into_iter().map(|t| t + self.late_s).collect()
    }

    /// Where the torque is unknown [s], in order.
    pub(crate) fn gaps(&self) -> &[(f64, f64)] {
        &self.gaps
    }
}

/// Times without a reading, in order; the first and the last are unbounded.
pub(crate) fn gaps(feedback: &Series) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (feedback.t_s.first(), feedback.t_s.last()) else { return vec![(f64::NEG_INFINITY, f64::INFINITY)] };
    let within = feedback.t_s.windows(2).filter(|t| t[1] - t[0] > LONGEST_GAP_S).map(|t| (t[0], t[1]));
    std::iter::once((f64::NEG_INFINITY, *first)).chain(within).chain([(*last, f64::INFINITY)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured() -> MeasuredTorque {
        let command = Series { t_s: vec![0.0, 1.0], value: vec![0.0, 20.0] };
        let t_s: Vec<f64> = (0..60).map(|k| f64::from(k) * 0.04).filter(|t| !(1.6..1.9).contains(t)).collect();
        let value = t_s.iter().map(|t| ((t - 1.1) * 60.0).clamp(0.0, 20.0)).collect();
        MeasuredTorque::new(&command, &Series { t_s, value }, 0.1)
    }

    #[test]
    fn a_ramp_is_followed_and_its_slope_is_the_derivative_by_dead_time() {
        let measured = measured();
        let at = measured.at(1.27);
        assert!((at.torque_nm - 10.2).abs() < 1e-9 && (at.by_dead_time + 60.0).abs() < 1e-9, "{at:?}");
        let mut cursor = measured.cursor();
        for t in [0.5, 1.21, 1.27, 1.3, 1.22, 2.2, 5.0, -1.0] {
            assert_eq!(cursor.at(t), measured.at(t));
        }
        let share = Share::new(1e-3);
        assert!(cursor.moves(1.24, 1.26, share) && !cursor.moves(1.24, 1.241, share));
    }

    #[test]
    fn steps_are_those_of_the_command_when_the_feedback_shows_them_and_gaps_are_reported() {
        assert_eq!(measured().steps(1.0), [1.1]);
        let gaps = measured().gaps().to_vec();
        assert!(gaps.len() == 3 && (gaps[1].0 - 1.56).abs() < 1e-9 && (gaps[1].1 - 1.92).abs() < 1e-9, "{gaps:?}");
        assert!(gaps[0].1.abs() < 1e-12 && gaps[2].1.is_infinite());
    }
}
