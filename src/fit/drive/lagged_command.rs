//! The drive between commanded and effective torque: a dead time T_d, then a first-order lag T_c.
//!
//! T_c·u̇ = c(t − T_d) − u, with the command c held between its samples. Between two changes of the command the solution is exact:
//! u(t) = c + (u₀ − c)·e^(−s/T_c), with s the time since the change. The derivatives follow:
//! ∂u/∂T_d = −u̇ and ∂u/∂T_c = w₀·e^(−s/T_c) + (u₀ − c)·e^(−s/T_c)·s/T_c².

use crate::fit::drive_form::torque::Torque;
use crate::signal::Series;

/// The lagged command of one log, for look-ups at any time.
#[derive(Debug, Clone)]
pub(crate) struct LaggedCommand {
    change_s: Vec<f64>,
    command_nm: Vec<f64>,
    torque_nm: Vec<f64>,
    by_lag: Vec<f64>,
    /// ln|u − c| at each change.
    ln_away: Vec<f64>,
    lag_s: f64,
    /// Largest torque commanded [N·m], and its logarithm.
    largest_nm: f64,
    ln_largest: f64,
}

/// A position in a lagged command that moves along with time: a look-up near the last one needs no search.
#[derive(Debug, Clone)]
pub(crate) struct LaggedCursor<'a> {
    lagged: &'a LaggedCommand,
    /// Number of changes at or before the time of the last look-up.
    passed: usize,
}

impl LaggedCursor<'_> {
    /// As [`LaggedCommand::at`].
    pub(crate) fn at(&mut self, t_s: f64) -> Torque {
        self.move_to(t_s);
        self.lagged.after(self.passed, t_s)
    }

    /// Whether the torque moves by more than `share` of the largest commanded between two times, in order.
    pub(crate) fn moves(&mut self, from_s: f64, to_s: f64, share: Share) -> bool {
        self.move_to(from_s);
        let LaggedCommand { change_s, ln_away, lag_s, ln_largest, .. } = self.lagged;
        // |u − c|·e^(−s/T_c) against the share, in logarithms
        let on_its_way =
            self.passed.checked_sub(1).is_some_and(|k| from_s - change_s[k] < lag_s * (ln_away[k] - ln_largest - share.logarithm));
        on_its_way || change_s.get(self.passed).is_some_and(|&t| t <= to_s)
    }

    fn move_to(&mut self, t_s: f64) {
        let changes = &self.lagged.change_s;
        while changes.get(self.passed).is_some_and(|&t| t <= t_s) {
            self.passed += 1;
        }
        while self.passed > 0 && changes[self.passed - 1] > t_s {
            self.passed -= 1;
        }
    }
}

/// A share of the largest torque, with its logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Share {
    pub(crate) value: f64,
    logarithm: f64,
}

impl Share {
    /// Of a positive value.
    pub(crate) fn new(value: f64) -> Self {
        Self { value, logarithm: value.ln() }
    }
}

/// A shorter lag counts as none [s].
const LEAST_LAG_S: f64 = 1e-4;

impl LaggedCommand {
    /// From the command, which is settled at its first value before it begins.
    pub(crate) fn new(command: &Series, lag_s: f64) -> Self {
        let mut lagged = Self {
            change_s: Vec::new(),
            command_nm: Vec::new(),
            torque_nm: Vec::new(),
            by_lag: Vec::new(),
            ln_away: Vec::new(),
            lag_s,
            largest_nm: 0.0,
            ln_largest: 0.0,
        };
        for (t, c) in command.t_s.iter().zip(&command.value) {
            if lagged.command_nm.last() == Some(c) {
                continue;
            }
            let state = if lagged.change_s.is_empty() { Torque::constant(*c) } else { lagged.at(*t) };
            lagged.change_s.push(*t);
            lagged.command_nm.push(*c);
            lagged.torque_nm.push(state.torque_nm);
            lagged.by_lag.push(state.by_drive[0]);
            lagged.ln_away.push((state.torque_nm - c).abs().ln());
            lagged.largest_nm = lagged.largest_nm.max(c.abs());
        }
        lagged.ln_largest = lagged.largest_nm.ln();
        lagged
    }

    /// Effective torque at `t_s` on the command's clock. The dead time is already subtracted: pass t − T_d.
    pub(crate) fn at(&self, t_s: f64) -> Torque {
        self.after(self.change_s.partition_point(|&t| t <= t_s), t_s)
    }

    /// A cursor at the beginning.
    pub(crate) fn cursor(&self) -> LaggedCursor<'_> {
        LaggedCursor { lagged: self, passed: 0 }
    }

    /// Effective torque at a time after `k` changes.
    fn after(&self, k: usize, t_s: f64) -> Torque {
        if k == 0 {
            return Torque::constant(self.command_nm.first().copied().unwrap_or(0.0));
        }
        let (since, c, u0, w0) = (t_s - self.change_s[k - 1], self.command_nm[k - 1], self.torque_nm[k - 1], self.by_lag[k - 1]);
        // e⁻¹⁶ of a step, 10⁻⁷, is negligible
        if self.lag_s < LEAST_LAG_S || since > 16.0 * self.lag_s {
            return Torque::constant(c);
        }
        let decay = (-since / self.lag_s).exp();
        let away = (u0 - c) * decay;
        let by_lag = w0 * decay + away * since / (self.lag_s * self.lag_s);
        Torque { torque_nm: c + away, by_dead_time: away / self.lag_s, by_drive: [by_lag, 0.0, 0.0, 0.0] }
    }

    /// Largest torque commanded [N·m].
    pub(crate) fn largest_nm(&self) -> f64 {
        self.largest_nm
    }

    /// Times at which the command changes by more than `least_nm` [s], on the command's clock.
    pub(crate) fn steps(&self, least_nm: f64) -> Vec<f64> {
        (1..self.change_s.len())
            .filter(|&k| (self.command_nm[k] - self.command_nm[k - 1]).abs() > least_nm)
            .map(|k| self.change_s[k])
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn command() -> Series {
        Series { t_s: vec![0.0, 1.0, 1.3], value: vec![0.0, 20.0, -5.0] }
    }

    #[test]
    fn a_step_rises_as_one_minus_e_to_the_minus_t_over_lag() {
        let lagged = LaggedCommand::new(&command(), 0.05);
        assert!((lagged.at(1.05).torque_nm - 20.0 * (1.0 - (-1.0f64).exp())).abs() < 1e-12);
        assert!(lagged.at(0.99).torque_nm.abs() < 1e-12);
    }

    #[test]
    fn the_derivatives_are_those_of_finite_differences() {
        let h = 1e-6;
        for t in [1.02, 1.2, 1.31, 1.4, 2.0] {
            let (lower, upper) = (LaggedCommand::new(&command(), 0.05 - h), LaggedCommand::new(&command(), 0.05 + h));
            let at = LaggedCommand::new(&command(), 0.05).at(t);
            let by_lag = (upper.at(t).torque_nm - lower.at(t).torque_nm) / (2.0 * h);
            assert!((at.by_drive[0] - by_lag).abs() < 1e-4 * (1.0 + by_lag.abs()), "{t}: {} {by_lag}", at.by_drive[0]);
            let same = LaggedCommand::new(&command(), 0.05);
            let by_dead_time = (same.at(t - h).torque_nm - same.at(t + h).torque_nm) / (2.0 * h);
            assert!((at.by_dead_time - by_dead_time).abs() < 1e-4 * (1.0 + by_dead_time.abs()), "{t}");
        }
    }
}
