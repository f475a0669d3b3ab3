//! The sensors: encoder, gyro, steering angle, torque feedback, localisation, each with its rate, quantisation, noise and delay.
//!
//! Encoder quantum = 2π r/(counts·period): the encoder takes the difference of the counts over one period, so it also reads half a period
//! late.

use crate::map::Vehicle;
use crate::sim::error::Result;
use crate::sim::random::{Random, Stream};
use crate::sim::sensor_settings::SensorSettings;
use crate::sim::sensor_timing::Channel;
use crate::units::RAD_PER_DEG;
use std::f64::consts::TAU;

/// Input of the sensors: the state at the end of a step, and its rates of change.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Scene {
    pub(crate) t_s: f64,
    pub(crate) rim_speed_mps: f64,
    pub(crate) accel_mps2: f64,
    pub(crate) rolled_m: f64,
    pub(crate) wheel_angle_rad: f64,
    pub(crate) wheel_angle_offset_rad: f64,
    pub(crate) torque_nm: f64,
    pub(crate) torque_slope_nm_s: f64,
    /// The effective torque as far as it is delivered [N·m].
    pub(crate) delivered_nm: f64,
    pub(crate) yaw_rate_rad_s: f64,
    pub(crate) yaw_accel_rad_s2: f64,
    pub(crate) pose: [f64; 3],
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
    /// Sensors without readings; until the first reading their values are zero.
    ///
    /// # Errors
    /// A setting is out of its range.
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

    /// Front-wheel speed from the encoder and the nominal radius [m/s].
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

    /// Leaves out the torque feedback.
    pub(crate) fn silence_torque_feedback(&mut self) {
        self.torque_feedback.silence();
    }

    /// Leaves out the gyro.
    pub(crate) fn silence_gyro(&mut self) {
        self.gyro.silence();
    }

    /// The next time at which [`Sensors::poll`] has work to do [s].
    #[inline]
    pub(crate) fn next_event_s(&self) -> f64 {
        self.next_event_s
    }

    /// Marks that the last step has no readings.
    #[inline]
    pub(crate) fn forget_taken(&mut self) {
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

    /// Advances all sensors to the time of `scene`.
    pub(crate) fn poll(&mut self, scene: &Scene) {
        let now_s = scene.t_s;
        let s = &self.settings;
        // a reading is between two steps: the state is extrapolated back to its time
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
            let reading_mps = noisy(speed_mps, encoder.noise_mps, random);
            if encoder.step_mps > 0.0 { (reading_mps / encoder.step_mps).round() * encoder.step_mps } else { reading_mps }
        });
        self.gyro.poll(now_s, |t_s, random| {
            let yaw_rate_rad_s = scene.yaw_rate_rad_s - scene.yaw_accel_rad_s2 * ago(t_s);
            noisy(yaw_rate_rad_s + s.gyro.bias_rad_s, s.gyro.noise_rad_s, random)
        });
        let angle = &s.steering_angle;
        self.steering_angle.poll(now_s, |_, random| {
            let true_deg = (scene.wheel_angle_rad + scene.wheel_angle_offset_rad) / RAD_PER_DEG;
            let deg = noisy(true_deg + angle.bias_deg, angle.noise_deg, random);
            RAD_PER_DEG * if angle.quantum_deg > 0.0 { (deg / angle.quantum_deg).round() * angle.quantum_deg } else { deg }
        });
        let feedback = &s.torque_feedback;
        self.torque_feedback.poll(now_s, |t_s, random| {
            let torque_nm = scene.torque_nm - scene.torque_slope_nm_s * ago(t_s);
            let shown_nm = if feedback.shows_limits && scene.delivered_nm != scene.torque_nm { scene.delivered_nm } else { torque_nm };
            noisy(feedback.scale * shown_nm + feedback.offset_nm, feedback.noise_nm, random)
        });
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
    use crate::sim::Timing;
    use crate::sim::sensor_settings::EncoderSettings;

    fn readings(settings: &SensorSettings, speed_mps: f64) -> Vec<f64> {
        let vehicle =
            Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };
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
        // the counts never lose distance: over 1000 readings the mean is exact to one count
        let mean = speeds[1..].iter().sum::<f64>() / (speeds.len() - 1) as f64;
        assert!((mean - 0.1).abs() < quantum / 900.0, "{mean}");
    }

    #[test]
    fn noise_and_scale_have_the_given_values() {
        let mut settings = SensorSettings::ideal();
        settings.encoder =
            EncoderSettings { counts_per_rev: 0, step_mps: 0.0, noise_mps: 0.006, scale: 1.01, timing: Timing::ideal(100.0) };
        let speeds = readings(&settings, 0.5);
        let n = speeds.len() as f64;
        let mean = speeds.iter().sum::<f64>() / n;
        let deviation = (speeds.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n).sqrt();
        // standard errors for 2000 readings: 0.00013 of the mean, 1.6 % of the deviation
        assert!((mean - 0.505).abs() < 5e-4 && (deviation / 0.006 - 1.0).abs() < 0.06, "{mean} {deviation}");
    }
}
