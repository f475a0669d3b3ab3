//! Traction: `(J_w/r²)·ṡ = (τ − τ_grip)/r` for the slip speed s of the rim over the floor. Beyond the grip the wheel spins up against its
//! own inertia, and only the grip torque reaches the floor. On a dry floor the grip is unlimited.

use crate::sim::drive::TorqueStep;

/// The contact between wheel and floor.
#[derive(Debug, Clone)]
pub(crate) struct Traction {
    grip_nm: f64,
    slip_mps: f64,
    /// Step over wheel mass and radius [m/s per N·m].
    slip_per_nm: f64,
}

impl Traction {
    /// A dry floor under a wheel of `wheel_mass_kg` at its rim.
    pub(crate) fn new(wheel_mass_kg: f64, wheel_radius_m: f64, step_s: f64) -> Self {
        Self { grip_nm: f64::INFINITY, slip_mps: 0.0, slip_per_nm: step_s / (wheel_mass_kg * wheel_radius_m) }
    }

    /// Largest torque on the floor [N·m]; infinity for a dry floor.
    pub(crate) fn set_grip_nm(&mut self, grip_nm: f64) {
        self.grip_nm = grip_nm.max(0.0);
    }

    /// Speed of the rim over the floor [m/s]; 0 while the wheel rolls.
    #[inline]
    pub(crate) fn slip_mps(&self) -> f64 {
        self.slip_mps
    }

    /// Torque that reaches the floor over one step.
    #[inline]
    pub(crate) fn step(&mut self, torque: TorqueStep) -> TorqueStep {
        let grip = self.grip_nm;
        if self.slip_mps == 0.0 && torque.start_nm.abs().max(torque.end_nm.abs()) <= grip {
            return torque;
        }
        let sign = if self.slip_mps == 0.0 { torque.mid_nm.signum() } else { self.slip_mps.signum() };
        let slip = self.slip_mps + self.slip_per_nm * (torque.mid_nm - sign * grip);
        if !slip.is_finite() || slip * sign <= 0.0 {
            self.slip_mps = 0.0;
            let held = |t: f64| t.clamp(-grip, grip);
            return TorqueStep { start_nm: held(torque.start_nm), mid_nm: held(torque.mid_nm), end_nm: held(torque.end_nm) };
        }
        self.slip_mps = slip;
        TorqueStep { start_nm: sign * grip, mid_nm: sign * grip, end_nm: sign * grip }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(torque_nm: f64) -> TorqueStep {
        TorqueStep { start_nm: torque_nm, mid_nm: torque_nm, end_nm: torque_nm }
    }

    #[test]
    fn beyond_the_grip_the_wheel_spins_and_the_grip_reaches_the_floor() {
        let mut traction = Traction::new(6.0, 0.12, 1e-3);
        traction.set_grip_nm(20.0);
        assert_eq!(traction.step(held(20.0)), held(20.0));
        for _ in 0..100 {
            assert_eq!(traction.step(held(30.0)), held(20.0));
        }
        // 0.1 s · 10 N·m / (6 kg · 0.12 m)
        assert!((traction.slip_mps() - 0.1 * 10.0 / 0.72).abs() < 1e-12);
        for _ in 0..200 {
            traction.step(held(0.0));
        }
        assert_eq!(traction.slip_mps(), 0.0);
        assert_eq!(traction.step(held(5.0)), held(5.0));
    }

    #[test]
    fn a_dry_floor_ends_the_slip_at_once() {
        let mut traction = Traction::new(6.0, 0.12, 1e-3);
        traction.set_grip_nm(20.0);
        traction.step(held(30.0));
        traction.set_grip_nm(f64::INFINITY);
        assert_eq!(traction.step(held(30.0)), held(30.0));
        assert_eq!(traction.slip_mps(), 0.0);
    }
}
