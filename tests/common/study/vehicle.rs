//! The true vehicles, forward gear: v̇ = (η_d·u⁺ + η_b·u⁻ − c − s·exp(−(v/v_s)²) − b·v − q·v²) / J, and what a physics family lacks.

/// Which vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Physics holds.
    Physics,
    /// Physics is wrong: a bump and a wave over (v, u) are added.
    Wrong,
}

/// A vehicle known to the last number.
#[derive(Debug, Clone)]
pub(crate) struct Truth {
    /// The parameters of v̇, of one kind or the other.
    pub(crate) parameters: Vec<f64>,
}

/// Dead time and lag of the drive [s].
pub(crate) const DEAD_TIME_S: f64 = 0.05;
pub(crate) const LAG_S: f64 = 0.05;
/// What is random is about as large as on the bundled `data/vehicles/scrubber.toml`. Standard deviation and time constant of the disturbance
/// [m/s², s], and standard deviation of one constant acceleration per run [m/s²].
pub(crate) const DISTURBANCE_MPS2: f64 = 0.02;
pub(crate) const DISTURBANCE_S: f64 = 0.25;
pub(crate) const OFFSET_MPS2: f64 = 0.005;
/// Encoder: noise and quantum [m/s]; yaw speed: noise [m/s].
pub(crate) const ENCODER_MPS: f64 = 0.006;
pub(crate) const QUANTUM_MPS: f64 = 0.009;
pub(crate) const YAW_MPS: f64 = 0.0072;

/// The vehicle of a kind. Effective inertia 13 kg·m (N·m per m/s²), 5 N·m Coulomb, 2.5 N·m Stribeck over 0.1 m/s.
pub(crate) fn truth(kind: Kind) -> Truth {
    let mut parameters = vec![0.92 / 13.0, 1.08 / 13.0, 5.0 / 13.0, 2.5 / 13.0, 0.1, 4.0 / 13.0, 2.0 / 13.0];
    if kind == Kind::Wrong {
        parameters.extend([0.25, 0.45, 0.15, 15.0, 8.0, 0.08, 0.6]);
    }
    Truth { parameters }
}

impl Truth {
    /// A(v, u) [m/s²].
    pub(crate) fn accel_mps2(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        accel_mps2(&self.parameters, speed_mps, torque_nm)
    }

    /// ∂A/∂u [m/s² per N·m].
    pub(crate) fn slope(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        (self.accel_mps2(speed_mps, torque_nm + 0.05) - self.accel_mps2(speed_mps, torque_nm - 0.05)) / 0.1
    }

    /// ∂A/∂v [1/s].
    pub(crate) fn by_speed(&self, speed_mps: f64, torque_nm: f64) -> f64 {
        (self.accel_mps2(speed_mps + 1e-4, torque_nm) - self.accel_mps2((speed_mps - 1e-4).max(0.0), torque_nm))
            / (1e-4 + speed_mps.min(1e-4))
    }

    /// ∂A/∂p of every parameter.
    pub(crate) fn by_parameters(&self, speed_mps: f64, torque_nm: f64) -> Vec<f64> {
        let mut moved = self.parameters.clone();
        (0..moved.len())
            .map(|k| {
                let (p, step) = (self.parameters[k], 1e-4 * self.parameters[k].abs());
                moved[k] = p + step;
                let above = accel_mps2(&moved, speed_mps, torque_nm);
                moved[k] = p - step;
                let below = accel_mps2(&moved, speed_mps, torque_nm);
                moved[k] = p;
                (above - below) / (2.0 * step)
            })
            .collect()
    }
}

fn accel_mps2(p: &[f64], v: f64, u: f64) -> f64 {
    let stribeck = v / p[4];
    let mut a = p[0] * u.max(0.0) + p[1] * u.min(0.0) - p[2] - p[3] * (-stribeck * stribeck).exp() - p[5] * v - p[6] * v * v;
    if let [height, v0, width_v, u0, width_u, wave, length] = p[7..] {
        let (x, y) = ((v - v0) / width_v, (u - u0) / width_u);
        a += height * (-x * x - y * y).exp() + wave * (std::f64::consts::TAU * v / length).sin() * (u / 15.0).tanh();
    }
    a
}
