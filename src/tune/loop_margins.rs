//! Margins of the speed loop on the identified drive, by the linear model: a map that inverts the plant leaves an integrator behind the
//! drive's dead time `T_d`, its lag `T_c`, and the hold of a control period.
//!
//! `L(s) = (Kp + Ki/s)/s · e^(−s·(T_d + Δt/2))/(T_c·s + 1)`. Source: Åström & Murray, *Feedback Systems*, §10.3.

use crate::control::WaypointLawSettings;
use serde::Serialize;
use std::f64::consts::PI;

/// Margins of the loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct LoopMargins {
    /// Factor by which the gain may grow; a map whose torque gives that factor of the acceleration is at the limit.
    pub(crate) gain: f64,
    /// Phase margin [°].
    pub(crate) phase_deg: f64,
    /// Additional dead time at the limit [s].
    pub(crate) delay_s: f64,
}

impl LoopMargins {
    /// For the gains of a law, and the drive's dead time and lag [s].
    pub(crate) fn new(law: &WaypointLawSettings, dead_time_s: f64, lag_s: f64) -> Self {
        let (kp, ki) = (law.speed_loop.proportional_per_s, law.speed_loop.integral_per_s2);
        let late_s = dead_time_s + 0.5 * law.period_s;
        let size = |w: f64| (kp * kp + ki * ki / (w * w)).sqrt() / w / (1.0 + (lag_s * w).powi(2)).sqrt();
        // of the controller −90°…0°, of the integrator −90°
        let phase = |w: f64| -(ki / w).atan2(kp) - 0.5 * PI - w * late_s - (lag_s * w).atan();
        let crossover = falling(|w| size(w) - 1.0);
        let turn_over = falling(|w| phase(w) + PI);
        Self { gain: 1.0 / size(turn_over), phase_deg: (phase(crossover) + PI).to_degrees(), delay_s: (phase(crossover) + PI) / crossover }
    }
}

/// Gain margin and phase margin [°] that a loop is to have. Source: Åström & Murray, §10.3: 2 to 5, and 30° to 60°.
const WANTED: (f64, f64) = (2.0, 45.0);

impl LoopMargins {
    /// Share of the wanted margins that is missing; 0 or less if none is.
    pub(crate) fn lack(&self) -> f64 {
        (1.0 - self.gain / WANTED.0).max(1.0 - self.phase_deg / WANTED.1)
    }
}

/// Where a function that falls over the frequency crosses zero last, 0.01 to 1000 rad/s.
fn falling(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high): (f64, f64) = (1e-2, 1e3);
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if f(middle) > 0.0 { low = middle } else { high = middle }
    }
    (low * high).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_proportional_loop_over_a_dead_time_has_the_textbook_margins() {
        let mut law = WaypointLawSettings::new(0.9);
        (law.period_s, law.speed_loop.integral_per_s2) = (0.0, 0.0);
        // L = Kp·e^(−sT)/s: crossover Kp, phase margin 90° − Kp·T, turn-over π/2T, gain margin π/(2·Kp·T), delay margin π/(2·Kp) − T
        let margins = LoopMargins::new(&law, 0.1, 0.0);
        assert!((margins.phase_deg - (90.0 - 0.3f64.to_degrees())).abs() < 1e-6, "{margins:?}");
        assert!((margins.gain - PI / 0.6).abs() < 1e-6, "{margins:?}");
        assert!((margins.delay_s - (PI / 6.0 - 0.1)).abs() < 1e-9, "{margins:?}");
    }
}
