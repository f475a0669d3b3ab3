//! A campaign of torque steps driven by a true vehicle, as a log would hold it, and as it really was. The driver uses the encoder's
//! readings, as `record` does: torques that depended on the true speed would contain information on it, which no estimator here uses.

use super::vehicle::{DEAD_TIME_S, DISTURBANCE_MPS2, DISTURBANCE_S, ENCODER_MPS, LAG_S, OFFSET_MPS2, QUANTUM_MPS, Truth, YAW_MPS};
use pivot_cal::map::{LogRef, Vehicle};
use pivot_cal::signal::{Series, Track};
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;

/// Step of the simulation [s]; commands and encoder come every tenth, the yaw rate every fifth.
const STEP_S: f64 = 2e-3;
/// A run is braked from here on, by the encoder [m/s].
const FASTEST_MPS: f64 = 1.1;

/// The true state at a yaw reading (every 10 ms).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    pub(crate) t_s: f64,
    pub(crate) speed_mps: f64,
    /// Effective torque, and its derivatives by dead time and lag.
    pub(crate) torque_nm: f64,
    pub(crate) by_dead_time: f64,
    pub(crate) by_lag: f64,
    /// The run, while the vehicle moves.
    pub(crate) run: Option<usize>,
    /// Time since the last step of the effective torque [s].
    pub(crate) since_step_s: f64,
    /// The mean of encoder and yaw speed around this moment [m/s]; at even samples, where the encoder reads.
    pub(crate) fused_mps: f64,
}

/// A campaign.
#[derive(Debug, Clone)]
pub(crate) struct Drive {
    pub(crate) track: Track,
    pub(crate) samples: Vec<Sample>,
}

/// What the driver does.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Push,
    Second,
    Stop,
    Rest,
}

impl Drive {
    /// Drives for `length_s`; every number of chance comes from `seed`.
    pub(crate) fn new(truth: &Truth, length_s: f64, seed: u64) -> Self {
        let mut chance = Pcg64::new(u128::from(seed), 0xa02b_dbf7_bb3c_0a7a_c28f_a16a_64ab_f96a);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut chance) };
        let mut chance = Pcg64::new(u128::from(seed), 0x5851_f42d_4c95_7f2d_1405_7b7e_f767_814f);
        let mut pick = move |values: &[f64]| -> f64 {
            let u: f64 = StandardUniform.sample(&mut chance);
            values[((u * values.len() as f64) as usize).min(values.len() - 1)]
        };
        let pushes: Vec<f64> = (0..10).map(|k| 11.0 + 2.5 * f64::from(k)).collect();
        let seconds: Vec<f64> = vec![0.0, -4.0, -8.0, -12.0, 3.0, 6.0, 12.0, 20.0, 28.0];

        let steps = (length_s / STEP_S) as usize;
        let delay = (DEAD_TIME_S / STEP_S).round() as usize;
        let mut commands: Vec<f64> = Vec::with_capacity(steps);
        let (mut phase, mut since, mut command) = (Phase::Rest, 0.0, 0.0);
        let (mut v, mut u, mut by_lag, mut d, mut offset) = (0.0f64, 0.0f64, 0.0f64, 0.0f64, 0.0f64);
        let (mut moving, mut runs, mut since_step_s) = (false, 0usize, 1.0);
        let decay = (-STEP_S / DISTURBANCE_S).exp();
        let follow = (-STEP_S / LAG_S).exp();
        let (mut commanded, mut encoder, mut yaw) = (Series::default(), Series::default(), Series::default());
        let mut samples: Vec<Sample> = Vec::with_capacity(steps / 5);
        for k in 0..steps {
            let t_s = k as f64 * STEP_S;
            if k % 10 == 0 {
                let read_mps = encoder.value.last().copied().unwrap_or(0.0);
                let next = match phase {
                    Phase::Rest if since > 0.8 => Some((Phase::Push, pick(&pushes))),
                    Phase::Push if read_mps > FASTEST_MPS || since > 2.2 => Some((Phase::Second, pick(&seconds))),
                    Phase::Second if read_mps > FASTEST_MPS || since > 1.6 || read_mps <= 0.0 => Some((Phase::Stop, -10.0)),
                    Phase::Stop if read_mps <= 0.0 => Some((Phase::Rest, 0.0)),
                    _ => None,
                };
                if let Some((p, c)) = next {
                    (phase, command, since) = (p, c, 0.0);
                }
                commanded.t_s.push(t_s);
                commanded.value.push(command);
            }
            commands.push(command);
            since += STEP_S;
            let late = if k >= delay { commands[k - delay] } else { 0.0 };
            since_step_s = if k > delay && (late - commands[k - delay - 1]).abs() > 0.1 { 0.0 } else { since_step_s + STEP_S };
            if k % 5 == 0 {
                yaw.t_s.push(t_s);
                yaw.value.push(v + YAW_MPS * normal());
                samples.push(Sample {
                    t_s,
                    speed_mps: v,
                    torque_nm: u,
                    by_dead_time: -(late - u) / LAG_S,
                    by_lag,
                    run: moving.then_some(runs),
                    since_step_s,
                    fused_mps: f64::NAN,
                });
            }
            if k % 10 == 0 {
                encoder.t_s.push(t_s);
                let noise = if moving { ENCODER_MPS * normal() } else { 0.0 };
                encoder.value.push(((v + noise) / QUANTUM_MPS).round() * QUANTUM_MPS);
            }
            // the lag exactly over the step, its derivative ẇ = −w/T − (c − u)/T² likewise
            let away = late - u;
            by_lag = follow * (by_lag - away * STEP_S / (LAG_S * LAG_S));
            let middle = late - away * follow.sqrt();
            u = late - away * follow;
            d = decay * d + DISTURBANCE_MPS2 * (1.0 - decay * decay).sqrt() * normal();
            if !moving && truth.accel_mps2(0.0, u) > 0.0 {
                moving = true;
                runs += 1;
                d = DISTURBANCE_MPS2 * normal();
                offset = OFFSET_MPS2 * normal();
            }
            if moving {
                let half = v + 0.5 * STEP_S * (truth.accel_mps2(v, u) + d + offset);
                v += STEP_S * (truth.accel_mps2(half.max(0.0), middle) + d + offset);
                // just after breakaway a disturbance may hold the wheel back: it stays about to move
                if v <= 0.0 {
                    v = 0.0;
                    moving = truth.accel_mps2(0.0, u) > 0.0;
                }
            }
        }
        for k in (2..samples.len().saturating_sub(1)).step_by(2) {
            let around = 0.25 * (yaw.value[k - 1] + 2.0 * yaw.value[k] + yaw.value[k + 1]);
            samples[k].fused_mps = 0.5 * (encoder.value[k / 2] + around);
        }
        let angle_rad = Series { t_s: encoder.t_s.clone(), value: vec![std::f64::consts::FRAC_PI_2; encoder.len()] };
        let gear = Series { t_s: encoder.t_s.clone(), value: vec![1.0; encoder.len()] };
        let vehicle = Vehicle {
            wheelbase_m: 1.2,
            wheel_radius_m: 0.1,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(40.0),
            torque_full_scale_nm: None,
        };
        let track = Track {
            source: LogRef { sha256: format!("{seed:064x}"), file: format!("seed_{seed}"), bytes: 0, loss: None },
            vehicle,
            wheel_angle_deg: vehicle.test_angle_deg,
            start_ns: 0,
            encoder_mps: encoder,
            yaw_speed_mps: Some(yaw),
            command_nm: commanded,
            command_std_s: 0.0,
            feedback_nm: None,
            angle_rad,
            gear: Some(gear),
            estop: None,
            notes: Vec::new(),
        };
        Self { track, samples }
    }

    /// Samples at the encoder's times with a fused speed.
    pub(crate) fn fused(&self) -> Vec<Sample> {
        self.samples.iter().copied().filter(|s| s.fused_mps.is_finite()).collect()
    }
}
