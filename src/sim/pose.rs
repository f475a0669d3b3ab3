//! The body: pose of the rear axle's middle from front-wheel speed and angle.
//!
//! ẋ = v cos δ cos θ, ẏ = v cos δ sin θ, θ̇ = v sin δ / L. Each step uses Simpson's rule, and the matching third-order weights
//! (5, 8, −1)/24 for θ at the middle: globally of fourth order. The heading's sine and cosine are updated by a rotation through the small
//! angle of the step (Taylor to the fifth power, error below 1e-16 for 3 mrad) and recomputed from time to time. During a pivot, cos δ is
//! zero to rounding: the reference point does not move and only the heading changes.

/// Front-wheel speed [m/s] over one step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SpeedStep {
    /// At its start.
    pub start_mps: f64,
    /// Half way.
    pub mid_mps: f64,
    /// At its end.
    pub end_mps: f64,
}

impl SpeedStep {
    /// Whether the wheel is at rest during the whole step.
    #[inline]
    pub(crate) fn is_rest(&self) -> bool {
        self.start_mps == 0.0 && self.mid_mps == 0.0 && self.end_mps == 0.0
    }

    /// Rolled distance in the step [m], by Simpson's rule.
    #[inline]
    pub(crate) fn distance_m(&self, step_s: f64) -> f64 {
        step_s * (self.start_mps + 4.0 * self.mid_mps + self.end_mps) * (1.0 / 6.0)
    }
}

/// Sine and cosine of the wheel angle over one step: at its start, middle and end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WheelAngleTerms {
    /// sin δ.
    pub sin: [f64; 3],
    /// cos δ.
    pub cos: [f64; 3],
    /// Whether the wheel is at 90° to rounding: cos 90° is 6e-17, which moves the reference point by less than 1e-13 m in a kilometre.
    across: bool,
    /// Angle at the end of the step [rad].
    end_rad: f64,
}

impl WheelAngleTerms {
    /// For a constant angle [rad].
    pub(crate) fn fixed(angle_rad: f64) -> Self {
        let (sin, cos) = angle_rad.sin_cos();
        Self { sin: [sin; 3], cos: [cos; 3], across: cos.abs() < 1e-15, end_rad: angle_rad }
    }

    /// For three angles [rad].
    pub(crate) fn moving(angles_rad: [f64; 3]) -> Self {
        Self { sin: angles_rad.map(f64::sin), cos: angles_rad.map(f64::cos), across: false, end_rad: angles_rad[2] }
    }

    /// Of three angles [rad]; where the first is the one at which the step before ended, its sine and cosine are known.
    pub(crate) fn after(&self, angles_rad: [f64; 3]) -> Self {
        let [start_rad, mid_rad, end_rad] = angles_rad;
        if start_rad.to_bits() != self.end_rad.to_bits() {
            return Self::moving(angles_rad);
        }
        let (sin, cos) = ([self.sin[2], mid_rad.sin(), end_rad.sin()], [self.cos[2], mid_rad.cos(), end_rad.cos()]);
        Self { sin, cos, across: false, end_rad }
    }
}

/// Pose of the rear axle's middle.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
    sin_heading: f64,
    cos_heading: f64,
    per_wheelbase: f64,
    yaw_rate_rad_s: f64,
    /// Number of steps until sine and cosine are recomputed; 0 if they are out of date.
    until_fresh: u32,
}

/// Number of steps after which sine and cosine are recomputed, against accumulated rounding errors.
const FRESH_EVERY: u32 = 256;
/// Largest step angle [rad] for which the short Taylor rotation is exact to rounding.
const SMALL_RAD: f64 = 3e-3;

impl Body {
    /// At the origin, heading along x.
    pub(crate) fn new(wheelbase_m: f64) -> Self {
        Self {
            x_m: 0.0,
            y_m: 0.0,
            heading_rad: 0.0,
            sin_heading: 0.0,
            cos_heading: 1.0,
            per_wheelbase: 1.0 / wheelbase_m,
            yaw_rate_rad_s: 0.0,
            until_fresh: FRESH_EVERY,
        }
    }

    /// x of the rear axle's middle [m].
    #[inline]
    pub(crate) fn x_m(&self) -> f64 {
        self.x_m
    }

    /// y of the rear axle's middle [m].
    #[inline]
    pub(crate) fn y_m(&self) -> f64 {
        self.y_m
    }

    /// Heading [rad], counter-clockwise, not wrapped.
    #[inline]
    pub(crate) fn heading_rad(&self) -> f64 {
        self.heading_rad
    }

    /// θ̇ at the end of the last step [rad/s].
    #[inline]
    pub(crate) fn yaw_rate_rad_s(&self) -> f64 {
        self.yaw_rate_rad_s
    }

    /// Cosine of the angle from `direction_rad` to the wheel's plane, from sin δ and cos δ: used for slopes.
    pub(crate) fn cos_of_wheel_from(&self, direction_rad: f64, sin_delta: f64, cos_delta: f64) -> f64 {
        let (sin, cos) = (self.heading_rad - direction_rad).sin_cos();
        cos * cos_delta - sin * sin_delta
    }

    /// Advances one step of `step_s`.
    #[inline]
    pub(crate) fn step(&mut self, step_s: f64, speed: SpeedStep, angle: &WheelAngleTerms) {
        if angle.across {
            let yaw_per_m = angle.sin[0] * self.per_wheelbase;
            self.heading_rad += speed.distance_m(step_s) * yaw_per_m;
            self.yaw_rate_rad_s = speed.end_mps * yaw_per_m;
            self.until_fresh = 0;
        } else if speed.is_rest() {
            self.rest();
        } else {
            self.travel(step_s, speed, angle);
        }
    }

    /// One step at rest: bit-identical to [`Body::step`] with speeds of zero, without the work.
    #[inline]
    pub(crate) fn rest(&mut self) {
        self.yaw_rate_rad_s = 0.0;
        self.count_down();
    }

    /// Recomputes sine and cosine from time to time.
    #[inline]
    fn count_down(&mut self) {
        if self.until_fresh == 0 {
            self.until_fresh = FRESH_EVERY;
            (self.sin_heading, self.cos_heading) = self.heading_rad.sin_cos();
        }
        self.until_fresh -= 1;
    }

    fn travel(&mut self, step_s: f64, speed: SpeedStep, angle: &WheelAngleTerms) {
        self.count_down();
        let v = [speed.start_mps, speed.mid_mps, speed.end_mps];
        let w =
            [v[0] * angle.sin[0] * self.per_wheelbase, v[1] * angle.sin[1] * self.per_wheelbase, v[2] * angle.sin[2] * self.per_wheelbase];
        let to_mid = step_s * (5.0 * w[0] + 8.0 * w[1] - w[2]) * (1.0 / 24.0);
        let to_end = step_s * (w[0] + 4.0 * w[1] + w[2]) * (1.0 / 6.0);
        let (sin0, cos0) = (self.sin_heading, self.cos_heading);
        let (sin1, cos1) = rotated(sin0, cos0, to_mid);
        let (sin2, cos2) = rotated(sin0, cos0, to_end);
        let along = [v[0] * angle.cos[0], 4.0 * v[1] * angle.cos[1], v[2] * angle.cos[2]];
        self.x_m += step_s * (1.0 / 6.0) * (along[0] * cos0 + along[1] * cos1 + along[2] * cos2);
        self.y_m += step_s * (1.0 / 6.0) * (along[0] * sin0 + along[1] * sin1 + along[2] * sin2);
        self.heading_rad += to_end;
        self.yaw_rate_rad_s = w[2];
        (self.sin_heading, self.cos_heading) = (sin2, cos2);
    }
}

/// Sine and cosine after a rotation by `by_rad`.
#[inline]
fn rotated(sin: f64, cos: f64, by_rad: f64) -> (f64, f64) {
    let (s, c) = if by_rad.abs() < SMALL_RAD {
        let q = by_rad * by_rad;
        (by_rad * (1.0 - q * (1.0 / 6.0) * (1.0 - q * (1.0 / 20.0))), 1.0 - q * 0.5 * (1.0 - q * (1.0 / 12.0)))
    } else {
        by_rad.sin_cos()
    };
    (sin * c + cos * s, cos * c - sin * s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_pivot_turns_by_arc_over_wheelbase_and_stays_in_place() {
        let mut body = Body::new(0.9);
        let terms = WheelAngleTerms::fixed(FRAC_PI_2);
        for _ in 0..10_000 {
            body.step(1e-3, SpeedStep { start_mps: 0.3, mid_mps: 0.3, end_mps: 0.3 }, &terms);
        }
        assert!((body.heading_rad() - 3.0 / 0.9).abs() < 1e-11);
        assert_eq!((body.x_m(), body.y_m()), (0.0, 0.0));
        // a wheel near 90° takes the general branch: sideways by cos δ
        let almost = WheelAngleTerms::fixed(FRAC_PI_2 - 1e-6);
        for _ in 0..1000 {
            body.step(1e-3, SpeedStep { start_mps: 0.3, mid_mps: 0.3, end_mps: 0.3 }, &almost);
        }
        assert!((body.heading_rad() - 3.3 / 0.9).abs() < 1e-11);
        assert!((1e-8..3.1e-7).contains(&body.x_m().hypot(body.y_m())));
    }

    #[test]
    fn terms_that_go_on_are_those_of_the_angles() {
        let expected = WheelAngleTerms::moving([0.3, 0.4, 0.5]);
        for before in [WheelAngleTerms::moving([0.1, 0.2, 0.3]), WheelAngleTerms::fixed(0.3), WheelAngleTerms::fixed(0.7)] {
            assert_eq!(before.after([0.3, 0.4, 0.5]), expected);
        }
    }

    #[test]
    fn a_step_at_rest_is_a_step_of_no_speed() {
        let (mut stepped, mut rested) = (Body::new(0.9), Body::new(0.9));
        let terms = WheelAngleTerms::fixed(0.6);
        for k in 0..1000 {
            let v = if k % 300 < 100 { 0.4 } else { 0.0 };
            let speed = SpeedStep { start_mps: v, mid_mps: v, end_mps: v };
            stepped.step(1e-3, speed, &terms);
            if speed.is_rest() { rested.rest() } else { rested.step(1e-3, speed, &terms) }
        }
        assert_eq!(format!("{stepped:?}"), format!("{rested:?}"));
    }

    #[test]
    fn a_constant_angle_draws_the_circle_of_the_bicycle_model() {
        let (wheelbase_m, delta) = (0.9, 0.6_f64);
        let mut body = Body::new(wheelbase_m);
        let terms = WheelAngleTerms::fixed(delta);
        for _ in 0..5000 {
            body.step(1e-3, SpeedStep { start_mps: 1.0, mid_mps: 1.0, end_mps: 1.0 }, &terms);
        }
        let radius_m = wheelbase_m / delta.tan();
        let heading = 5.0 * delta.sin() / wheelbase_m;
        assert!((body.heading_rad() - heading).abs() < 1e-11);
        assert!((body.x_m() - radius_m * heading.sin()).abs() < 1e-11);
        assert!((body.y_m() - radius_m * (1.0 - heading.cos())).abs() < 1e-11);
    }

    /// Error of the pose after 2 s of a smooth manoeuvre at a step of `step_s`, against a step 64 times finer.
    fn pose(steps: u32) -> [f64; 3] {
        let step_s = 2.0 / f64::from(steps);
        let v = |t: f64| 1.0 + 0.5 * (3.0 * t).sin();
        let delta = |t: f64| 0.9 * (2.0 * t).cos();
        let mut body = Body::new(0.9);
        for k in 0..steps {
            let t = [0.0, 0.5, 1.0].map(|part| (f64::from(k) + part) * step_s);
            let speed = SpeedStep { start_mps: v(t[0]), mid_mps: v(t[1]), end_mps: v(t[2]) };
            body.step(step_s, speed, &WheelAngleTerms::moving(t.map(delta)));
        }
        [body.x_m(), body.y_m(), body.heading_rad()]
    }

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() {
        let exact = pose(12_800);
        let error = |steps| pose(steps).iter().zip(exact).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let (coarse, fine, finest) = (error(25), error(50), error(100));
        for order in [(coarse / fine).log2(), (fine / finest).log2()] {
            assert!((3.7..4.6).contains(&order), "order {order}: errors {coarse:e} {fine:e} {finest:e}");
        }
    }
}
