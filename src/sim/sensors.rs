//! The sensors: encoder, gyro, steering angle, torque feedback, localisation; each with its rate, quantisation, noise and delay.
//!
//! The encoder counts: it differences the counts of one period, so it is quantised by 2π r/(counts·period) and reads half a period late.

use super::channel::{Channel, Timing};
use super::error::{Result, within};
use super::random::{Random, Stream};
use crate::map::{PlantNoise, Vehicle};
use crate::units::RAD_PER_DEG;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Settings of the front wheel's encoder.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EncoderSettings {
    /// Counts per revolution; 0 for one that reads the speed itself. Default 4096.
    pub counts_per_rev: u32,
    /// Standard deviation of a reading [m/s]. Default 0.006.
    pub noise_mps: f64,
    /// Reading over true speed: a rolling radius that is not the nominal one. Default 1.
    pub scale: f64,
    /// When it reads.
    pub timing: Timing,
}

/// Settings of the gyro.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GyroSettings {
    /// Standard deviation of a reading [rad/s]. Default 0.008.
    pub noise_rad_s: f64,
    /// Bias [rad/s]. Default 0.0015.
    pub bias_rad_s: f64,
    /// When it reads. Default 100 Hz.
    pub timing: Timing,
}

/// Settings of the steering angle sensor.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SteeringAngleSettings {
    /// Standard deviation of a reading [°]. Default 0.15.
    pub noise_deg: f64,
    /// Bias [°]. Default 0.25.
    pub bias_deg: f64,
    /// Step of the reading [°]; 0 for none. Default 0.01.
    pub quantum_deg: f64,
    /// When it reads.
    pub timing: Timing,
}

/// Settings of the drive's torque feedback.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TorqueFeedbackSettings {
    /// Standard deviation of a reading [N·m]. Default 0.3.
    pub noise_nm: f64,
    /// When it reads.
    pub timing: Timing,
}

/// Settings of the localisation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PoseSettings {
    /// Standard deviation of x and of y [m]. Default 0.002.
    pub noise_m: f64,
    /// Standard deviation of the heading [°]. Default 0.05.
    pub noise_deg: f64,
    /// When it reads. Default 50 Hz.
    pub timing: Timing,
}

/// Settings of all sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSettings {
    /// The front wheel's encoder.
    pub encoder: EncoderSettings,
    /// The gyro.
    pub gyro: GyroSettings,
    /// The steering angle sensor.
    pub steering_angle: SteeringAngleSettings,
    /// The drive's torque feedback.
    pub torque_feedback: TorqueFeedbackSettings,
    /// The localisation.
    pub pose: PoseSettings,
}

impl Default for EncoderSettings {
    fn default() -> Self {
        Self { counts_per_rev: 4096, noise_mps: 0.006, scale: 1.0, timing: Timing::default() }
    }
}

impl Default for GyroSettings {
    fn default() -> Self {
        Self { noise_rad_s: 0.008, bias_rad_s: 0.0015, timing: Timing { rate_hz: 100.0, ..Timing::default() } }
    }
}

impl Default for SteeringAngleSettings {
    fn default() -> Self {
        Self { noise_deg: 0.15, bias_deg: 0.25, quantum_deg: 0.01, timing: Timing::default() }
    }
}

impl Default for TorqueFeedbackSettings {
    fn default() -> Self {
        Self { noise_nm: 0.3, timing: Timing::default() }
    }
}

impl Default for PoseSettings {
    fn default() -> Self {
        Self { noise_m: 0.002, noise_deg: 0.05, timing: Timing::default() }
    }
}

impl SensorSettings {
    /// Sensors that read the truth every millisecond.
    pub fn ideal() -> Self {
        let timing = Timing::ideal(1000.0);
        Self {
            encoder: EncoderSettings { counts_per_rev: 0, noise_mps: 0.0, scale: 1.0, timing },
            gyro: GyroSettings { noise_rad_s: 0.0, bias_rad_s: 0.0, timing },
            steering_angle: SteeringAngleSettings { noise_deg: 0.0, bias_deg: 0.0, quantum_deg: 0.0, timing },
            torque_feedback: TorqueFeedbackSettings { noise_nm: 0.0, timing },
            pose: PoseSettings { noise_m: 0.0, noise_deg: 0.0, timing },
        }
    }

    /// What a fit knows of the sensors: the speed noise; the rest is usual, without biases, which a calibrated vehicle has taken out.
    pub fn identified(noise: &PlantNoise) -> Self {
        let usual = Self::default();
        Self {
            encoder: EncoderSettings { counts_per_rev: 0, noise_mps: noise.speed_noise_mps, ..usual.encoder },
            gyro: GyroSettings { bias_rad_s: 0.0, ..usual.gyro },
            steering_angle: SteeringAngleSettings { bias_deg: 0.0, ..usual.steering_angle },
            ..usual
        }
    }

    /// The same with every noise multiplied.
    #[must_use]
    pub fn with_noise_factor(mut self, factor: f64) -> Self {
        self.encoder.noise_mps *= factor;
        self.gyro.noise_rad_s *= factor;
        self.steering_angle.noise_deg *= factor;
        self.torque_feedback.noise_nm *= factor;
        self.pose.noise_m *= factor;
        self.pose.noise_deg *= factor;
        self
    }

    fn check(&self) -> Result<()> {
        let noise = 0.0..=100.0;
        within("sensors.encoder.noise_mps", self.encoder.noise_mps, noise.clone(), "0 to 100")?;
        within("sensors.encoder.scale", self.encoder.scale, 0.1..=10.0, "0.1 to 10")?;
        within("sensors.gyro.noise_rad_s", self.gyro.noise_rad_s, noise.clone(), "0 to 100")?;
        within("sensors.gyro.bias_rad_s", self.gyro.bias_rad_s, -10.0..=10.0, "-10 to 10")?;
        within("sensors.steering_angle.noise_deg", self.steering_angle.noise_deg, noise.clone(), "0 to 100")?;
        within("sensors.steering_angle.bias_deg", self.steering_angle.bias_deg, -180.0..=180.0, "-180 to 180")?;
        within("sensors.steering_angle.quantum_deg", self.steering_angle.quantum_deg, 0.0..=10.0, "0 to 10")?;
        within("sensors.torque_feedback.noise_nm", self.torque_feedback.noise_nm, 0.0..=1e4, "0 to 1e4")?;
        within("sensors.pose.noise_m", self.pose.noise_m, noise.clone(), "0 to 100")?;
        within("sensors.pose.noise_deg", self.pose.noise_deg, noise, "0 to 100")
    }
}

/// What the sensors look at: the state at the end of a step, and how it is changing.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Scene {
    pub(super) t_s: f64,
    pub(super) rim_speed_mps: f64,
    pub(super) accel_mps2: f64,
    pub(super) rolled_m: f64,
    pub(super) wheel_angle_rad: f64,
    pub(super) wheel_angle_offset_rad: f64,
    pub(super) torque_nm: f64,
    pub(super) yaw_rate_rad_s: f64,
    pub(super) pose: [f64; 3],
}

/// The sensors' state.
#[derive(Debug, Clone)]
pub struct Sensors {
    settings: SensorSettings,
    encoder: Channel<f64>,
    gyro: Channel<f64>,
    steering_angle: Channel<f64>,
    torque_feedback: Channel<f64>,
    pose: Channel<[f64; 3]>,
    counts_per_m: f64,
    last_rolled: f64,
    next_event_s: f64,
    took: bool,
}

impl Sensors {
    /// Sensors that have not read anything yet; until then they say zero.
    ///
    /// # Errors
    /// A setting out of its range.
    pub fn new(settings: &SensorSettings, vehicle: &Vehicle, seed: u64) -> Result<Self> {
        settings.check()?;
        Ok(Self {
            settings: *settings,
            encoder: Channel::new(&settings.encoder.timing, seed, Stream::Encoder, 0.0)?,
            gyro: Channel::new(&settings.gyro.timing, seed, Stream::Gyro, 0.0)?,
            steering_angle: Channel::new(&settings.steering_angle.timing, seed, Stream::SteeringAngle, 0.0)?,
            torque_feedback: Channel::new(&settings.torque_feedback.timing, seed, Stream::TorqueFeedback, 0.0)?,
            pose: Channel::new(&settings.pose.timing, seed, Stream::Pose, [0.0; 3])?,
            counts_per_m: f64::from(settings.encoder.counts_per_rev) / (TAU * vehicle.wheel_radius_m),
            last_rolled: 0.0,
            next_event_s: 0.0,
            took: false,
        })
    }

    /// Front-wheel speed by the encoder and the nominal radius [m/s].
    pub fn encoder(&self) -> &Channel<f64> {
        &self.encoder
    }

    /// Yaw rate [rad/s].
    pub fn gyro(&self) -> &Channel<f64> {
        &self.gyro
    }

    /// Wheel angle [rad].
    pub fn steering_angle(&self) -> &Channel<f64> {
        &self.steering_angle
    }

    /// Effective torque [N·m].
    pub fn torque_feedback(&self) -> &Channel<f64> {
        &self.torque_feedback
    }

    /// x [m], y [m], heading [rad] of the rear axle's middle.
    pub fn pose(&self) -> &Channel<[f64; 3]> {
        &self.pose
    }

    /// The next time at which [`Sensors::poll`] has anything to do [s].
    #[inline]
    pub(super) fn next_event_s(&self) -> f64 {
        self.next_event_s
    }

    /// Nothing was read in the last step.
    #[inline]
    pub(super) fn forget_taken(&mut self) {
        if self.took {
            self.forget_all_taken();
        }
    }

    fn forget_all_taken(&mut self) {
        self.took = false;
        self.encoder.forget_taken();
        self.gyro.forget_taken();
        self.steering_angle.forget_taken();
        self.torque_feedback.forget_taken();
        self.pose.forget_taken();
    }

    /// Brings all sensors to the time of `scene`.
    pub(super) fn poll(&mut self, scene: &Scene) {
        let now_s = scene.t_s;
        let s = &self.settings;
        // a reading falls between two steps: the state is carried back to its time
        let ago = |t_s: f64| now_s - t_s;
        let noisy = |value: f64, deviation: f64, random: &mut Random| {
            if deviation > 0.0 { value + deviation * random.normal() } else { value }
        };
        let (encoder, counts_per_m, last) = (&s.encoder, self.counts_per_m, &mut self.last_rolled);
        let period_s = self.encoder.period_s();
        self.encoder.poll(now_s, |t_s, random| {
            let dt = ago(t_s);
            let speed_mps = if encoder.counts_per_rev == 0 {
                encoder.scale * (scene.rim_speed_mps - scene.accel_mps2 * dt)
            } else {
                let rolled_m = encoder.scale * (scene.rolled_m - dt * (scene.rim_speed_mps - 0.5 * scene.accel_mps2 * dt));
                let counts = (rolled_m * counts_per_m).floor();
                (counts - std::mem::replace(last, counts)) / (counts_per_m * period_s)
            };
            noisy(speed_mps, encoder.noise_mps, random)
        });
        self.gyro.poll(now_s, |_, random| noisy(scene.yaw_rate_rad_s + s.gyro.bias_rad_s, s.gyro.noise_rad_s, random));
        let angle = &s.steering_angle;
        self.steering_angle.poll(now_s, |_, random| {
            let true_deg = (scene.wheel_angle_rad + scene.wheel_angle_offset_rad) / RAD_PER_DEG;
            let deg = noisy(true_deg + angle.bias_deg, angle.noise_deg, random);
            RAD_PER_DEG * if angle.quantum_deg > 0.0 { (deg / angle.quantum_deg).round() * angle.quantum_deg } else { deg }
        });
        self.torque_feedback.poll(now_s, |_, random| noisy(scene.torque_nm, s.torque_feedback.noise_nm, random));
        let pose = &s.pose;
        self.pose.poll(now_s, |t_s, random| {
            let [x, y, heading] = scene.pose;
            let heading = heading - scene.yaw_rate_rad_s * ago(t_s);
            [noisy(x, pose.noise_m, random), noisy(y, pose.noise_m, random), noisy(heading, pose.noise_deg * RAD_PER_DEG, random)]
        });
        self.took = true;
        self.next_event_s = self
            .encoder
            .next_event_s()
            .min(self.gyro.next_event_s())
            .min(self.steering_angle.next_event_s())
            .min(self.torque_feedback.next_event_s())
            .min(self.pose.next_event_s());
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn readings(settings: &SensorSettings, speed_mps: f64) -> Vec<f64> {
        let vehicle = Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None };
        let mut sensors = Sensors::new(settings, &vehicle, 5).unwrap();
        let mut speeds = Vec::new();
        for k in 0..20_000 {
            let t_s = f64::from(k) * 1e-3;
            sensors.forget_taken();
            if t_s < sensors.next_event_s() {
                continue;
            }
            sensors.poll(&Scene { t_s, rim_speed_mps: speed_mps, rolled_m: speed_mps * t_s, ..Scene::default() });
            speeds.extend(sensors.encoder().taken().map(|r| r.value));
        }
        speeds
    }

    #[test]
    fn encoder_counts_make_steps_of_the_quantum_and_a_true_mean() {
        let mut settings = SensorSettings::ideal();
        settings.encoder = EncoderSettings { noise_mps: 0.0, timing: Timing::ideal(50.0), ..EncoderSettings::default() };
        let speeds = readings(&settings, 0.1);
        let quantum = TAU * 0.12 / 4096.0 / 0.02;
        assert!((quantum - 0.0092).abs() < 1e-4);
        for speed in &speeds[1..] {
            assert!(((speed / quantum).round() - speed / quantum).abs() < 1e-9, "{speed} is a whole number of quanta");
        }
        // the counts never lose distance: over 1000 readings the mean is true to one count
        let mean = speeds[1..].iter().sum::<f64>() / (speeds.len() - 1) as f64;
        assert!((mean - 0.1).abs() < quantum / 900.0, "{mean}");
    }

    #[test]
    fn noise_and_scale_are_as_told() {
        let mut settings = SensorSettings::ideal();
        settings.encoder = EncoderSettings { counts_per_rev: 0, noise_mps: 0.006, scale: 1.01, timing: Timing::ideal(100.0) };
        let speeds = readings(&settings, 0.5);
        let n = speeds.len() as f64;
        let mean = speeds.iter().sum::<f64>() / n;
        let deviation = (speeds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n).sqrt();
        // standard errors for 2000 readings: 0.00013 of the mean, 1.6 % of the deviation
        assert!((mean - 0.505).abs() < 5e-4 && (deviation / 0.006 - 1.0).abs() < 0.06, "{mean} {deviation}");
    }
}
