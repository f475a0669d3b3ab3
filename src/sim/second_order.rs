//! A second-order drive, T₀²·ü + T₁·u̇ + u = τ, stepped exactly under a command that is constant over a step.

use std::f64::consts::TAU;

/// How the state (u − τ, u̇) moves over half a step and over a whole one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SecondOrderStep {
    half: [[f64; 2]; 2],
    whole: [[f64; 2]; 2],
    /// u̇ [N·m/s].
    rate_nm_s: f64,
}

impl SecondOrderStep {
    /// At rest, for a natural frequency, a damping (1: critical) and a step.
    pub(crate) fn new(frequency_hz: f64, damping: f64, step_s: f64) -> Self {
        let w = TAU * frequency_hz;
        Self { half: transition(w, damping, 0.5 * step_s), whole: transition(w, damping, step_s), rate_nm_s: 0.0 }
    }

    /// Takes the drive to rest.
    pub(crate) fn settle(&mut self) {
        self.rate_nm_s = 0.0;
    }

    /// The torque half way and at the end of a step from `torque_nm` under `command_nm` [N·m].
    pub(crate) fn step(&mut self, torque_nm: f64, command_nm: f64) -> [f64; 2] {
        let away = torque_nm - command_nm;
        let mid = self.half[0][0] * away + self.half[0][1] * self.rate_nm_s;
        let end = self.whole[0][0] * away + self.whole[0][1] * self.rate_nm_s;
        self.rate_nm_s = self.whole[1][0] * away + self.whole[1][1] * self.rate_nm_s;
        [command_nm + mid, command_nm + end]
    }
}

/// exp(A·t) of ë + 2ζω·ė + ω²·e = 0.
fn transition(w: f64, damping: f64, t_s: f64) -> [[f64; 2]; 2] {
    let decay = damping * w;
    let squared = decay * decay - w * w;
    let x = squared * t_s * t_s;
    // cos and sin/ω, hyperbolic above critical damping; the series where both meet
    let (c, s) = if x < -1e-9 {
        let r = (-squared).sqrt();
        ((r * t_s).cos(), (r * t_s).sin() / r)
    } else if x > 1e-9 {
        let r = squared.sqrt();
        ((r * t_s).cosh(), (r * t_s).sinh() / r)
    } else {
        (1.0 + 0.5 * x, t_s * (1.0 + x / 6.0))
    };
    let fade = (-decay * t_s).exp();
    [[fade * (c + decay * s), fade * s], [-fade * w * w * s, fade * (c - decay * s)]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_step_response_is_the_textbooks() {
        let (hz, damping, h) = (6.0, 0.2, 1e-3);
        let mut drive = SecondOrderStep::new(hz, damping, h);
        let (w, root) = (TAU * hz, (1.0f64 - damping * damping).sqrt());
        let mut torque = 0.0;
        for k in 1..400 {
            torque = drive.step(torque, 20.0)[1];
            let t = f64::from(k) * h;
            let expected = 20.0 * (1.0 - (-damping * w * t).exp() * ((w * root * t).cos() + damping / root * (w * root * t).sin()));
            assert!((torque - expected).abs() < 1e-9, "{t}: {torque} {expected}");
        }
    }

    #[test]
    fn a_damped_drive_creeps_to_its_command_without_passing_it() {
        let mut drive = SecondOrderStep::new(3.0, 1.5, 1e-3);
        let mut torque = 0.0;
        for _ in 0..3000 {
            torque = drive.step(torque, 20.0)[1];
            assert!(torque <= 20.0 + 1e-9);
        }
        assert!((torque - 20.0).abs() < 1e-3);
    }
}
