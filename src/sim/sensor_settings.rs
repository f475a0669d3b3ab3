//! Settings of the sensors: noise, quantisation, bias and timing of each.

use crate::map::PlantNoise;
use crate::sim::error::{Result, within};
use crate::sim::sensor_timing::Timing;
use serde::{Deserialize, Serialize};

/// Settings of the front wheel's encoder.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EncoderSettings {
    /// Counts per revolution; 0 for an encoder that measures the speed directly. Default 4096.
    pub counts_per_rev: u32,
    /// Step of the reading of an encoder that measures the speed directly [m/s]; 0, the default, for none.
    pub step_mps: f64,
    /// Standard deviation of a reading [m/s]. Default 0.006.
    pub noise_mps: f64,
    /// Reading over true speed: an error of the nominal rolling radius. Default 1.
    pub scale: f64,
    /// Timing of the readings.
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
    /// Timing of the readings. Default 100 Hz.
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
    /// Timing of the readings.
    pub timing: Timing,
}

/// Settings of the drive's torque feedback.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TorqueFeedbackSettings {
    /// Standard deviation of a reading [N·m]. Default 0.3.
    pub noise_nm: f64,
    /// Reading over effective torque: 1, the default, for the torque at the wheel.
    pub scale: f64,
    /// Reading at no torque [N·m]. Default 0.
    pub offset_nm: f64,
    /// Whether it shows what a power limit and a governor take away. Default false: it stands before them.
    pub shows_limits: bool,
    /// Timing of the readings.
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
    /// Timing of the readings. Default 50 Hz.
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
        Self { counts_per_rev: 4096, step_mps: 0.0, noise_mps: 0.006, scale: 1.0, timing: Timing::default() }
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
        Self { noise_nm: 0.3, scale: 1.0, offset_nm: 0.0, shows_limits: false, timing: Timing::default() }
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
            encoder: EncoderSettings { counts_per_rev: 0, step_mps: 0.0, noise_mps: 0.0, scale: 1.0, timing },
            gyro: GyroSettings { noise_rad_s: 0.0, bias_rad_s: 0.0, timing },
            steering_angle: SteeringAngleSettings { noise_deg: 0.0, bias_deg: 0.0, quantum_deg: 0.0, timing },
            torque_feedback: TorqueFeedbackSettings { noise_nm: 0.0, timing, ..TorqueFeedbackSettings::default() },
            pose: PoseSettings { noise_m: 0.0, noise_deg: 0.0, timing },
        }
    }

    /// The sensors of a fit: its speed noise and the step of its readings, usual values for the rest, and no biases, which are removed on a calibrated vehicle.
    pub fn identified(noise: &PlantNoise) -> Self {
        let usual = Self::default();
        Self {
            encoder: EncoderSettings {
                counts_per_rev: 0,
                step_mps: noise.speed_step_mps,
                noise_mps: noise.speed_noise_mps,
                ..usual.encoder
            },
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

    pub(crate) fn check(&self) -> Result<()> {
        let noise = 0.0..=100.0;
        within("sensors.encoder.noise_mps", self.encoder.noise_mps, noise.clone(), "0 to 100")?;
        within("sensors.encoder.step_mps", self.encoder.step_mps, 0.0..=10.0, "0 to 10")?;
        within("sensors.encoder.scale", self.encoder.scale, 0.1..=10.0, "0.1 to 10")?;
        within("sensors.gyro.noise_rad_s", self.gyro.noise_rad_s, noise.clone(), "0 to 100")?;
        within("sensors.gyro.bias_rad_s", self.gyro.bias_rad_s, -10.0..=10.0, "-10 to 10")?;
        within("sensors.steering_angle.noise_deg", self.steering_angle.noise_deg, noise.clone(), "0 to 100")?;
        within("sensors.steering_angle.bias_deg", self.steering_angle.bias_deg, -180.0..=180.0, "-180 to 180")?;
        within("sensors.steering_angle.quantum_deg", self.steering_angle.quantum_deg, 0.0..=10.0, "0 to 10")?;
        within("sensors.torque_feedback.noise_nm", self.torque_feedback.noise_nm, 0.0..=1e4, "0 to 1e4")?;
        within("sensors.torque_feedback.scale", self.torque_feedback.scale, -1e3..=1e3, "-1000 to 1000")?;
        within("sensors.torque_feedback.offset_nm", self.torque_feedback.offset_nm, -1e4..=1e4, "-1e4 to 1e4")?;
        within("sensors.pose.noise_m", self.pose.noise_m, noise.clone(), "0 to 100")?;
        within("sensors.pose.noise_deg", self.pose.noise_deg, noise, "0 to 100")
    }
}
