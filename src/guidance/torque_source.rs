//! The torque source of a manoeuvre: the maps under test, or a substitute.

/// Gives the torque for an acceleration at a speed and a wheel angle, in the vehicle's frame.
pub(crate) trait TorqueSource {
    /// Torque [N·m], positive drives forward, for front-wheel speed [m/s], desired acceleration of the front wheel [m/s²] (both forward
    /// positive) and wheel angle [rad] (left positive). Speed 0 means "just moving forward", −0.0 "just moving in reverse". The result is
    /// within the drive's limit; 0 for NaN.
    fn torque_nm(&self, speed_mps: f64, accel_mps2: f64, wheel_angle_rad: f64) -> f64;
}

impl<T: TorqueSource + ?Sized> TorqueSource for &T {
    fn torque_nm(&self, speed_mps: f64, accel_mps2: f64, wheel_angle_rad: f64) -> f64 {
        (**self).torque_nm(speed_mps, accel_mps2, wheel_angle_rad)
    }
}
