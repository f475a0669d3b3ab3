//! The single-track model with its control point in the middle between the axles.
//!
//! ```text
//! β = arctan(½ tan δ)    ẋ = v cos(ψ + β)    ẏ = v sin(ψ + β)    ψ̇ = v cos β tan δ/L    δ̇ = w(t)    v̇ = a(t)
//! ```
//!
//! β is the slip angle of the control point, δ the front wheel's angle, w and a are constant on each segment. The explicit Euler method
//! steps with the rates at the start of the step; the classical Runge-Kutta method is of fourth order. A segment's last step is shortened to end
//! with the segment. Source: Rajamani, *Vehicle Dynamics and Control*, 2nd ed., §2.2; Hairer, Nørsett & Wanner, *Solving ODEs I*, §II.1.

use crate::guidance::body::within;
use crate::guidance::{BodyShape, Result};
use serde::Serialize;

/// A vehicle with a limited front wheel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Car {
    /// Outline and wheelbase.
    pub body: BodyShape,
    /// Steering wheel angle over front wheel angle; 1 without a steering wheel.
    pub steering_ratio: f64,
    /// Largest angle of the steering wheel [rad].
    pub steering_limit_rad: f64,
}

impl Car {
    /// Checks every number.
    ///
    /// # Errors
    /// The first out of its range.
    pub fn checked(self) -> Result<Self> {
        self.body.checked()?;
        within("steering_ratio", self.steering_ratio, 0.1, 100.0, "0.1 to 100")?;
        within("front wheel limit", self.wheel_limit_rad(), 0.01, 1.48, "0.01 to 1.48 rad (85°)").map(|()| self)
    }

    /// Largest angle of the front wheel [rad].
    pub fn wheel_limit_rad(&self) -> f64 {
        self.steering_limit_rad / self.steering_ratio
    }

    /// Curvature of the control point at a wheel angle [1/m].
    pub fn curvature_per_m(&self, wheel_angle_rad: f64) -> f64 {
        slip_rad(wheel_angle_rad).cos() * wheel_angle_rad.tan() / self.body.wheelbase_m
    }
}

/// Slip angle of the point in the middle between the axles [rad].
pub(crate) fn slip_rad(wheel_angle_rad: f64) -> f64 {
    (0.5 * wheel_angle_rad.tan()).atan()
}

/// State of the control point.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct UTurnState {
    /// Time [s].
    pub t_s: f64,
    /// East of the origin [m].
    pub x_m: f64,
    /// North of the origin [m].
    pub y_m: f64,
    /// Heading ψ [rad], not wrapped.
    pub heading_rad: f64,
    /// Front wheel angle δ [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Speed of the control point [m/s].
    pub speed_mps: f64,
}

/// A time during which wheel rate and acceleration are constant.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct SteeringSegment {
    /// Its length [s].
    pub duration_s: f64,
    /// w [rad/s], left positive.
    pub wheel_rate_rad_s: f64,
    /// a [m/s²].
    pub accel_mps2: f64,
}

/// Method of integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Explicit Euler, first order: the published one.
    Euler,
    /// Classical Runge-Kutta, fourth order.
    RungeKutta,
}

/// Largest number of steps of one segment.
const MOST_STEPS: f64 = 1e6;

/// Integrates from `start` over `segments` and passes every state after the first to `see`. A duration below zero or not finite counts as
/// zero.
pub(crate) fn integrate(
    car: &Car,
    start: UTurnState,
    segments: &[SteeringSegment],
    step_s: f64,
    method: Method,
    mut see: impl FnMut(&UTurnState),
) -> UTurnState {
    let mut state = start;
    for segment in segments {
        let duration_s = if segment.duration_s.is_finite() { segment.duration_s.max(0.0) } else { 0.0 };
        let begin = state;
        // 1e-9: a duration of whole steps, apart from rounding, has no empty step at its end
        let count = (duration_s / step_s - 1e-9).ceil().clamp(0.0, MOST_STEPS) as usize;
        for k in 0..count {
            let from_s = k as f64 * step_s;
            let to_s = if k + 1 == count { duration_s } else { from_s + step_s };
            let mut next = advance(car, &state, segment, to_s - from_s, method);
            // linear in time, not a sum of steps, so that the wheel returns exactly to its start
            next.t_s = begin.t_s + to_s;
            next.wheel_angle_rad = begin.wheel_angle_rad + segment.wheel_rate_rad_s * to_s;
            next.speed_mps = begin.speed_mps + segment.accel_mps2 * to_s;
            state = next;
            see(&state);
        }
    }
    state
}

/// (ẋ, ẏ, ψ̇).
fn rates(car: &Car, heading_rad: f64, wheel_angle_rad: f64, speed_mps: f64) -> [f64; 3] {
    // cos β = 1/√(1 + tan²β) with tan β = ½ tan δ
    let tan = wheel_angle_rad.tan();
    let slip = (0.5 * tan).atan();
    let (sin, cos) = (heading_rad + slip).sin_cos();
    [speed_mps * cos, speed_mps * sin, speed_mps * tan / (1.0 + 0.25 * tan * tan).sqrt() / car.body.wheelbase_m]
}

fn advance(car: &Car, from: &UTurnState, segment: &SteeringSegment, h: f64, method: Method) -> UTurnState {
    let at = |part: f64, rate: &[f64; 3]| {
        rates(
            car,
            from.heading_rad + part * h * rate[2],
            from.wheel_angle_rad + part * h * segment.wheel_rate_rad_s,
            from.speed_mps + part * h * segment.accel_mps2,
        )
    };
    let k1 = at(0.0, &[0.0; 3]);
    let rate = match method {
        Method::Euler => k1,
        Method::RungeKutta => {
            let k2 = at(0.5, &k1);
            let k3 = at(0.5, &k2);
            let k4 = at(1.0, &k3);
            [0, 1, 2].map(|i| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0)
        }
    };
    UTurnState { x_m: from.x_m + h * rate[0], y_m: from.y_m + h * rate[1], heading_rad: from.heading_rad + h * rate[2], ..*from }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn car() -> Car {
        Car { body: BodyShape::usual(2.0), steering_ratio: 16.0, steering_limit_rad: 470.0_f64.to_radians() }
    }

    #[test]
    fn a_steady_wheel_draws_the_circle_of_the_slip_model() {
        let (car, angle) = (car(), 0.4);
        let start = UTurnState { wheel_angle_rad: angle, speed_mps: 1.0, ..UTurnState::default() };
        let segment = SteeringSegment { duration_s: 3.0, ..SteeringSegment::default() };
        let end = integrate(&car, start, &[segment], 0.01, Method::RungeKutta, |_| {});
        let (kappa, slip) = (car.curvature_per_m(angle), slip_rad(angle));
        assert!((end.heading_rad - 3.0 * kappa).abs() < 1e-12);
        assert!((end.x_m - ((slip + 3.0 * kappa).sin() - slip.sin()) / kappa).abs() < 1e-9);
        assert!((end.y_m + ((slip + 3.0 * kappa).cos() - slip.cos()) / kappa).abs() < 1e-9);
    }

    #[test]
    fn the_methods_have_their_orders() {
        let segments = [
            SteeringSegment { duration_s: 1.2, wheel_rate_rad_s: 0.4, accel_mps2: 0.5 },
            SteeringSegment { duration_s: 1.2, wheel_rate_rad_s: -0.4, accel_mps2: -0.5 },
        ];
        let start = UTurnState { speed_mps: 2.0, ..UTurnState::default() };
        let end = |step_s: f64, method| integrate(&car(), start, &segments, step_s, method, |_| {});
        let exact = end(0.0005, Method::RungeKutta);
        for (method, order, step_s) in [(Method::Euler, 1.0, 0.02), (Method::RungeKutta, 4.0, 0.1)] {
            let error = |step_s: f64| (end(step_s, method).x_m - exact.x_m).hypot(end(step_s, method).y_m - exact.y_m);
            let found = (error(step_s) / error(0.5 * step_s)).log2();
            assert!((found - order).abs() < 0.3, "{method:?}: order {found}");
        }
    }
}
