//! The effective torque of a drive that is not a plain first-order lag: its response to the command, sampled finely after each change and
//! linear between the samples.
//!
//! Each sample is exact: between changes of a held command a rate limit is a ramp and then a constant, a lag follows a ramp in closed form,
//! and a second-order lag follows a constant in closed form. Derivatives by the parameters are central differences of such responses, and
//! ∂u/∂T_d = −u̇.

use crate::fit::drive::lagged_command::{LaggedCommand, Share};
use crate::fit::drive_form::drive_model::{DriveKind, DriveModel};
use crate::fit::drive_form::parameters::PARAMETERS;
use crate::fit::drive_form::torque::Torque;
use crate::signal::Series;

/// Samples after a change: the shortest and the longest distance [s].
const SAMPLE_S: (f64, f64) = (1e-3, 8e-3);
/// A lag has settled after so many time constants.
const SETTLED: f64 = 10.0;
/// Relative change of a parameter for its derivative, and the least change [s].
const DIFFERENCE: (f64, f64) = (1e-3, 1e-5);

/// The torque of one log, for look-ups at any time.
#[derive(Debug, Clone)]
pub(crate) struct SampledTorque {
    t_s: Vec<f64>,
    torque_nm: Vec<f64>,
    by_drive: Vec<[f64; PARAMETERS]>,
    command: LaggedCommand,
}

/// A position in a sampled torque that moves along with time.
#[derive(Debug, Clone)]
pub(crate) struct SampledCursor<'a> {
    sampled: &'a SampledTorque,
    /// Number of samples at or before the time of the last look-up.
    passed: usize,
}

impl SampledCursor<'_> {
    /// Effective torque at `t_s` on the command's clock. The dead time is already subtracted: pass t − T_d.
    pub(crate) fn at(&mut self, t_s: f64) -> Torque {
        let times = &self.sampled.t_s;
        while times.get(self.passed).is_some_and(|&t| t <= t_s) {
            self.passed += 1;
        }
        while self.passed > 0 && times[self.passed - 1] > t_s {
            self.passed -= 1;
        }
        self.sampled.after(self.passed, t_s)
    }

    /// Whether the torque moves by more than `share` of the largest between two times, in order.
    pub(crate) fn moves(&mut self, from_s: f64, to_s: f64, share: Share) -> bool {
        let from = self.at(from_s);
        let least_nm = share.value * self.sampled.largest_nm();
        let mut ahead = self.clone();
        let to = ahead.at(to_s);
        let samples = &self.sampled.torque_nm[self.passed.min(ahead.passed)..ahead.passed];
        samples.iter().chain([&to.torque_nm]).any(|u| (u - from.torque_nm).abs() > least_nm)
            || to.by_dead_time.abs().max(from.by_dead_time.abs()) * SAMPLE_S.1 > least_nm
    }
}

impl SampledTorque {
    /// The response of a drive to the changes of a command. Before the first change it has settled.
    pub(crate) fn new(command: &Series, drive: &DriveModel) -> Self {
        let t_s = sample_times(command, drive);
        let torque_nm = response(command, drive, &t_s);
        let mut by_drive = vec![[0.0; PARAMETERS]; t_s.len()];
        for parameter in (0..drive.times_s.len()).filter(|p| drive.has()[*p]) {
            let by = (DIFFERENCE.0 * drive.times_s[parameter]).max(DIFFERENCE.1);
            let shifted = |by: f64| {
                let mut times_s = drive.times_s;
                times_s[parameter] += by;
                let shifted = drive.with(times_s);
                (shifted.times_s[parameter], response(command, &shifted, &t_s))
            };
            let ((low_s, low), (high_s, high)) = (shifted(-by), shifted(by));
            for (all, (a, b)) in by_drive.iter_mut().zip(low.iter().zip(&high)) {
                all[parameter] = (b - a) / (high_s - low_s).max(1e-12);
            }
        }
        Self { t_s, torque_nm, by_drive, command: LaggedCommand::new(command, 0.0) }
    }

    /// Effective torque at `t_s` on the command's clock. The dead time is already subtracted: pass t − T_d.
    #[cfg(test)]
    fn at(&self, t_s: f64) -> Torque {
        self.after(self.t_s.partition_point(|&t| t <= t_s), t_s)
    }

    /// A cursor at the beginning.
    pub(crate) fn cursor(&self) -> SampledCursor<'_> {
        SampledCursor { sampled: self, passed: 0 }
    }

    /// Torque at a time after `k` samples.
    fn after(&self, k: usize, t_s: f64) -> Torque {
        if k == 0 || k == self.t_s.len() {
            let end = self.torque_nm.get(k.saturating_sub(1)).copied().unwrap_or(0.0);
            return Torque::constant(end);
        }
        let length_s = (self.t_s[k] - self.t_s[k - 1]).max(1e-12);
        let share = (t_s - self.t_s[k - 1]) / length_s;
        let between = |a: f64, b: f64| a + share * (b - a);
        let (u0, u1) = (self.torque_nm[k - 1], self.torque_nm[k]);
        let (d0, d1) = (&self.by_drive[k - 1], &self.by_drive[k]);
        Torque { torque_nm: between(u0, u1), by_dead_time: -(u1 - u0) / length_s, by_drive: std::array::from_fn(|p| between(d0[p], d1[p])) }
    }

    /// Largest torque commanded [N·m].
    pub(crate) fn largest_nm(&self) -> f64 {
        self.command.largest_nm()
    }

    /// Times at which the command changes by more than `least_nm` [s], on the command's clock.
    pub(crate) fn steps(&self, least_nm: f64) -> Vec<f64> {
        self.command.steps(least_nm)
    }
}

/// Times of the samples: close together after each change until the drive has settled.
fn sample_times(command: &Series, drive: &DriveModel) -> Vec<f64> {
    let [a, b, _] = drive.times_s;
    let lag_s = drive.lag_s();
    let spacing_s = match drive.kind {
        DriveKind::SecondOrder => a / 12.0,
        _ => lag_s.max(0.016) / 8.0,
    };
    let spacing_s = spacing_s.clamp(SAMPLE_S.0, SAMPLE_S.1);
    let mut t_s = Vec::new();
    let mut before_nm = command.value.first().copied().unwrap_or(0.0);
    let mut open_until_s = f64::NEG_INFINITY;
    for (k, (&from_s, &value)) in command.t_s.iter().zip(&command.value).enumerate() {
        // a drive that has not settled after the last change needs longer: the largest change is to the other limit
        let way_nm = (value - before_nm).abs().max(if open_until_s > from_s { 2.0 * drive.reference_nm } else { 0.0 });
        let settles_s = match (drive.slopes_nm_s(), drive.kind) {
            (Some(slopes), _) => way_nm / slopes[0].min(slopes[1]) + SETTLED * lag_s + 2.0 * spacing_s,
            // of a pair of poles, the envelope fades with 2·T₀²/T₁; of two real ones, the slow one with about T₁
            (None, DriveKind::SecondOrder) => SETTLED * (2.0 * a * a / b).max(b),
            (None, _) => SETTLED * lag_s,
        };
        open_until_s = from_s + settles_s;
        let to_s = command.t_s.get(k + 1).copied().unwrap_or(f64::INFINITY).min(open_until_s);
        let count = ((to_s - from_s) / spacing_s).ceil().max(1.0) as usize;
        t_s.extend((0..=count).map(|n| from_s + (to_s - from_s) * n as f64 / count as f64));
        before_nm = value;
    }
    t_s.sort_unstable_by(f64::total_cmp);
    t_s.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    t_s
}

/// The torque at the times `t_s`, which rise and include every change of the command.
fn response(command: &Series, drive: &DriveModel, t_s: &[f64]) -> Vec<f64> {
    let Some(&first_nm) = command.value.first() else { return vec![0.0; t_s.len()] };
    let mut state = DriveState { ramp_nm: first_nm, torque_nm: first_nm, rate_nm_s: 0.0 };
    let mut held = 0;
    let mut now_s = t_s.first().copied().unwrap_or(0.0);
    t_s.iter()
        .map(|&t| {
            // the command that was held until now
            while held + 1 < command.len() && command.t_s[held + 1] <= now_s + 1e-9 {
                held += 1;
            }
            state.go_on(drive, command.value[held], t - now_s);
            now_s = t;
            state.torque_nm
        })
        .collect()
}

/// The state of a drive.
#[derive(Debug, Clone, Copy)]
struct DriveState {
    /// The command after a rate limit [N·m].
    ramp_nm: f64,
    /// u [N·m].
    torque_nm: f64,
    /// u̇ [N·m/s].
    rate_nm_s: f64,
}

impl DriveState {
    /// Advances by `dt_s` under a constant command.
    fn go_on(&mut self, drive: &DriveModel, command_nm: f64, dt_s: f64) {
        if drive.kind == DriveKind::SecondOrder {
            self.second_order(drive, command_nm, dt_s);
            return;
        }
        if drive.slopes_nm_s().is_none() {
            self.ramp_nm = command_nm;
        }
        let mut left_s = dt_s;
        // the pieces of a ramp: its slope changes where it crosses zero, and where it ends
        for _ in 0..3 {
            let (slope, target_nm) = slope(drive, self.ramp_nm, command_nm);
            let piece_s = if slope == 0.0 { left_s } else { left_s.min((target_nm - self.ramp_nm) / slope) };
            self.follow_ramp(drive.lag_s(), slope, piece_s);
            if slope != 0.0 && piece_s < left_s {
                self.ramp_nm = target_nm;
            }
            left_s -= piece_s;
            if left_s <= 0.0 {
                break;
            }
        }
    }

    /// A first-order lag behind a ramp: u = r − s·T + (u₀ − r₀ + s·T)·e^(−t/T).
    fn follow_ramp(&mut self, lag_s: f64, slope_nm_s: f64, dt_s: f64) {
        let end_nm = self.ramp_nm + slope_nm_s * dt_s;
        if lag_s < 1e-5 {
            self.torque_nm = end_nm;
        } else {
            let behind_nm = slope_nm_s * lag_s;
            self.torque_nm = end_nm - behind_nm + (self.torque_nm - self.ramp_nm + behind_nm) * (-dt_s / lag_s).exp();
        }
        self.ramp_nm = end_nm;
    }

    /// e = u − c with T₀²·ë + T₁·ė + e = 0.
    fn second_order(&mut self, drive: &DriveModel, command_nm: f64, dt_s: f64) {
        let [natural_s, damped_s, _] = drive.times_s;
        let decay = damped_s / (2.0 * natural_s * natural_s);
        let squared = decay * decay - 1.0 / (natural_s * natural_s);
        let (e, rate) = (self.torque_nm - command_nm, self.rate_nm_s);
        let slope = rate + decay * e;
        // cos and sin/ω, hyperbolic above critical damping; the series where both meet
        let (fade, x) = ((-decay * dt_s).exp(), squared * dt_s * dt_s);
        let (c, s) = if x < -1e-6 {
            let w = (-squared).sqrt();
            ((w * dt_s).cos(), (w * dt_s).sin() / w)
        } else if x > 1e-6 {
            let w = squared.sqrt();
            ((w * dt_s).cosh(), (w * dt_s).sinh() / w)
        } else {
            (1.0 + 0.5 * x, dt_s * (1.0 + x / 6.0))
        };
        self.torque_nm = command_nm + fade * (e * c + slope * s);
        self.rate_nm_s = fade * (rate * c - (decay * rate + e / (natural_s * natural_s)) * s);
    }
}

/// The slope of a ramp from `from_nm` to a command [N·m/s], and where it ends or changes [N·m].
fn slope(drive: &DriveModel, from_nm: f64, command_nm: f64) -> (f64, f64) {
    let way_nm = command_nm - from_nm;
    let Some([first, second]) = drive.slopes_nm_s().filter(|_| way_nm != 0.0) else { return (0.0, command_nm) };
    match drive.kind {
        DriveKind::UpDown => (if way_nm > 0.0 { first } else { -second }, command_nm),
        DriveKind::GrowingFalling => {
            let falls = from_nm != 0.0 && (from_nm > 0.0) != (way_nm > 0.0);
            let target_nm = if falls && command_nm * from_nm < 0.0 { 0.0 } else { command_nm };
            (if falls { second } else { first }.copysign(way_nm), target_nm)
        }
        _ => (first.copysign(way_nm), command_nm),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn command() -> Series {
        Series { t_s: vec![0.0, 1.0, 3.0, 4.1], value: vec![0.0, 20.0, -8.0, 12.0] }
    }

    fn drive(kind: DriveKind, times_s: [f64; 3]) -> DriveModel {
        DriveModel::of_kind(kind, 20.0).with(times_s)
    }

    /// Integrated in steps of 20 µs.
    fn integrated(kind: DriveKind, times_s: [f64; 3], until_s: f64) -> f64 {
        let (mut r, mut u, mut rate) = (0.0f64, 0.0f64, 0.0f64);
        let h = 2e-5;
        for k in 0..(until_s / h).round() as usize {
            let c = command().held((k as f64 + 0.5) * h).unwrap_or(0.0);
            let [a, b, lag] = times_s;
            if kind == DriveKind::SecondOrder {
                rate += h * (c - u - b * rate) / (a * a);
                u += h * rate;
                continue;
            }
            let (up, down) = (20.0 / a * h, 20.0 / if kind == DriveKind::RateLimit { a } else { b } * h);
            let (low, high) = if kind == DriveKind::GrowingFalling {
                (if r > 0.0 { -down } else { -up }, if r < 0.0 { down } else { up })
            } else {
                (-down, up)
            };
            r += (c - r).clamp(low, high);
            let lag = if kind == DriveKind::RateLimit { b } else { lag };
            u += h * (r - u) / lag;
        }
        u
    }

    #[test]
    fn every_drive_follows_its_equation() {
        for (kind, times_s) in [
            (DriveKind::RateLimit, [0.4, 0.03, 0.0]),
            (DriveKind::GrowingFalling, [0.5, 0.2, 0.04]),
            (DriveKind::UpDown, [0.3, 0.8, 0.02]),
            (DriveKind::SecondOrder, [1.0 / (TAU * 6.0), 0.4 / (TAU * 6.0), 0.0]),
            (DriveKind::SecondOrder, [0.05, 0.13, 0.0]),
        ] {
            let sampled = SampledTorque::new(&command(), &drive(kind, times_s));
            let mut cursor = sampled.cursor();
            for t in [0.5, 1.05, 1.21, 1.5, 2.9, 3.07, 3.4, 3.9, 4.0, 4.2, 4.6, 9.0] {
                let (found, expected) = (cursor.at(t).torque_nm, integrated(kind, times_s, t));
                assert!((found - expected).abs() < 0.06, "{kind:?} {t}: {found} {expected}");
                assert_eq!(found, sampled.at(t).torque_nm);
            }
        }
    }

    #[test]
    fn derivatives_by_the_parameters_are_those_of_other_drives() {
        for (kind, times_s) in [(DriveKind::RateLimit, [0.4, 0.03, 0.0]), (DriveKind::SecondOrder, [0.0265, 0.0106, 0.0])] {
            let sampled = SampledTorque::new(&command(), &drive(kind, times_s));
            for p in 0..2 {
                let other = |by: f64| {
                    let mut times_s = times_s;
                    times_s[p] += by;
                    SampledTorque::new(&command(), &drive(kind, times_s))
                };
                let (low, high) = (other(-2e-4), other(2e-4));
                for t in [1.1, 1.23, 3.2, 4.3] {
                    let expected = (high.at(t).torque_nm - low.at(t).torque_nm) / 4e-4;
                    let found = sampled.at(t).by_drive[p];
                    assert!((found - expected).abs() < 0.05 * expected.abs() + 2.0, "{kind:?} {p} {t}: {found} {expected}");
                }
            }
        }
    }
}
