//! One U-turn: the run-up, the three phases that turn the heading by exactly 180°, and the track that comes of them.

use crate::guidance::body::within;
use crate::guidance::geometry::Polygon;
use crate::guidance::u_turn::model::{Car, Method, SteeringSegment, UTurnState, integrate};
use crate::guidance::{Error, PathPose, PosePath, Result};
use crate::map::Gear;
use serde::Serialize;
use std::f64::consts::{FRAC_PI_2, PI};

/// The three things that are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct UTurnShape {
    /// Length of the straight run-up [m].
    pub run_up_m: f64,
    /// Speed of the control point at the end of the run-up [m/s].
    pub speed_mps: f64,
    /// Rate of the steering wheel, in and out [rad/s].
    pub steering_rate_rad_s: f64,
}

/// How a U-turn is computed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UTurnSettings {
    /// Step [s]. Default 0.01.
    pub step_s: f64,
    /// Method. Default Euler, the published one.
    pub method: Method,
    /// Acceleration from rest in the run-up, until the speed is reached [m/s²]. Default 3.
    pub run_up_accel_mps2: f64,
    /// Acceleration in each of the three phases [m/s²]. Default none.
    pub turn_accel_mps2: [f64; 3],
}

impl Default for UTurnSettings {
    fn default() -> Self {
        Self { step_s: 0.01, method: Method::Euler, run_up_accel_mps2: 3.0, turn_accel_mps2: [0.0; 3] }
    }
}

/// A U-turn to the left from the origin, heading along y.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct UTurnTrack {
    /// The turn.
    pub turn: UTurnShape,
    /// The vehicle.
    pub car: Car,
    /// States of the control point, every step.
    pub states: Vec<UTurnState>,
    /// Lengths of the three phases [s]; the hold is 0 where the wheel does not reach its limit.
    pub phases_s: [f64; 3],
    /// Largest front wheel angle [rad].
    pub peak_wheel_rad: f64,
}

/// Drives a U-turn.
///
/// # Errors
/// A number out of its range, a run-up too short for the speed, or a vehicle that stops in the turn, with the nearest that goes.
pub fn drive(car: &Car, turn: &UTurnShape, settings: &UTurnSettings) -> Result<UTurnTrack> {
    let car = car.checked()?;
    within("run_up_m", turn.run_up_m, 0.0, 1000.0, "0 to 1000")?;
    within("speed_mps", turn.speed_mps, 0.01, 50.0, "0.01 to 50")?;
    within("steering_rate_rad_s", turn.steering_rate_rad_s, 0.01, 100.0, "0.01 to 100")?;
    within("step_s", settings.step_s, 1e-4, 0.1, "0.0001 to 0.1")?;
    within("run_up_accel_mps2", settings.run_up_accel_mps2, 0.01, 100.0, "0.01 to 100")?;
    for accel in settings.turn_accel_mps2 {
        within("turn_accel_mps2", accel, -20.0, 20.0, "-20 to 20")?;
    }
    let rising_s = turn.speed_mps / settings.run_up_accel_mps2;
    let rising_m = 0.5 * turn.speed_mps * rising_s;
    if rising_m > turn.run_up_m {
        return Err(Error::RunUpTooShort {
            speed_mps: turn.speed_mps,
            run_up_m: turn.run_up_m,
            accel_mps2: settings.run_up_accel_mps2,
            nearest_m: rising_m,
        });
    }
    let steady_s = (turn.run_up_m - rising_m) / turn.speed_mps;
    let mut states = vec![UTurnState { heading_rad: FRAC_PI_2, ..UTurnState::default() }];
    let run_up = [
        SteeringSegment { duration_s: rising_s, accel_mps2: settings.run_up_accel_mps2, wheel_rate_rad_s: 0.0 },
        SteeringSegment { duration_s: steady_s, ..SteeringSegment::default() },
    ];
    let mut state = integrate(&car, states[0], &run_up, settings.step_s, settings.method, |s| states.push(*s));
    // straight and exact: what Euler's method loses while the speed rises is not the turn's
    (state.x_m, state.y_m, state.speed_mps) = (0.0, turn.run_up_m, turn.speed_mps);
    if let Some(last) = states.last_mut() {
        *last = state;
    }
    let phases_s = phases(&car, turn, settings)?;
    let segments = segments(&car, turn, settings, phases_s);
    integrate(&car, state, &segments, settings.step_s, settings.method, |s| states.push(*s));
    let peak_wheel_rad = phases_s[0] * turn.steering_rate_rad_s / car.steering_ratio;
    Ok(UTurnTrack { turn: *turn, car, states, phases_s, peak_wheel_rad })
}

fn segments(car: &Car, turn: &UTurnShape, settings: &UTurnSettings, phases_s: [f64; 3]) -> [SteeringSegment; 3] {
    let rate = turn.steering_rate_rad_s / car.steering_ratio;
    [0, 1, 2].map(|k| SteeringSegment {
        duration_s: phases_s[k],
        wheel_rate_rad_s: [rate, 0.0, -rate][k],
        accel_mps2: settings.turn_accel_mps2[k],
    })
}

/// Lengths of the phases [s] for a turn of exactly 180° by this method and step: with the wheel to its limit the hold is what is missing; where
/// wheel in and out alone turn further, there is no hold and the wheel stops short of its limit.
fn phases(car: &Car, turn: &UTurnShape, settings: &UTurnSettings) -> Result<[f64; 3]> {
    let start = UTurnState { speed_mps: turn.speed_mps, ..UTurnState::default() };
    let mut slowest = f64::INFINITY;
    let mut turned = |phases_s: [f64; 3]| {
        slowest = turn.speed_mps;
        let end = integrate(car, start, &segments(car, turn, settings, phases_s), settings.step_s, settings.method, |s| {
            slowest = slowest.min(s.speed_mps);
        });
        (end.heading_rad, slowest)
    };
    let full_s = car.wheel_limit_rad() * car.steering_ratio / turn.steering_rate_rad_s;
    let (by_wheel, _) = turned([full_s, 0.0, full_s]);
    let with = |part: f64| if by_wheel < PI { [full_s, part, full_s] } else { [part, 0.0, part] };
    let (mut low, mut high) = if by_wheel < PI {
        let rate = turn.speed_mps * car.curvature_per_m(car.wheel_limit_rad());
        (0.0, (PI - by_wheel) / rate * 1.5 + 1.0)
    } else {
        (0.0, full_s)
    };
    for _ in 0..6 {
        if turned(with(high)).0 >= PI || by_wheel >= PI {
            break;
        }
        high *= 2.0;
    }
    let stops = |heading: f64, speed: f64| heading.is_nan() || speed <= 0.0;
    let (mut at_low, (mut at_high, slow)) = (turned(with(low)).0 - PI, turned(with(high)));
    at_high -= PI;
    if at_high < 0.0 || stops(at_high, slow.max(1e-9)) {
        // v² = v₀² − 2 |a| s over the way that the turn takes at its tightest
        let decel = settings.turn_accel_mps2.iter().fold(0.0, |d: f64, &a| d.max(-a));
        let way_m = PI / car.curvature_per_m(car.wheel_limit_rad()) + turn.speed_mps * full_s;
        return Err(Error::StopsInTurn { turned_deg: (at_high + PI).to_degrees(), nearest_mps: (2.0 * decel * way_m).sqrt() });
    }
    // the Illinois method; Source: Dowell & Jarratt (1971)
    let mut root = 0.5 * (low + high);
    for _ in 0..60 {
        root = if at_high == at_low { 0.5 * (low + high) } else { (low * at_high - high * at_low) / (at_high - at_low) };
        let value = turned(with(root)).0 - PI;
        if value.abs() < 1e-13 {
            break;
        }
        if value > 0.0 {
            (high, at_high) = (root, value);
            at_low *= 0.5;
        } else {
            (low, at_low) = (root, value);
            at_high *= 0.5;
        }
        if high - low < 1e-14 {
            break;
        }
    }
    let (heading, slow) = turned(with(root));
    if slow <= 0.0 {
        let decel = settings.turn_accel_mps2.iter().fold(0.0, |d: f64, &a| d.max(-a));
        let way_m = PI / car.curvature_per_m(car.wheel_limit_rad()) + turn.speed_mps * full_s;
        return Err(Error::StopsInTurn { turned_deg: heading.to_degrees(), nearest_mps: (2.0 * decel * way_m).sqrt() });
    }
    Ok(with(root))
}

impl UTurnTrack {
    /// The last state.
    pub fn end(&self) -> UTurnState {
        self.states[self.states.len() - 1]
    }

    /// Index of the first state of the turn.
    pub fn turn_from(&self) -> usize {
        let begin_s = self.end().t_s - self.phases_s.iter().sum::<f64>();
        self.states.partition_point(|s| s.t_s < begin_s - 1e-9)
    }

    /// The outline at a state.
    pub fn body(&self, state: &UTurnState) -> Polygon {
        let half = 0.5 * self.car.body.wheelbase_m;
        let (sin, cos) = state.heading_rad.sin_cos();
        self.car.body.at(state.x_m - half * cos, state.y_m - half * sin, state.heading_rad)
    }

    /// The rear axle's path, a pose every `step_m` of its way (the last piece is shorter).
    pub fn path(&self, step_m: f64) -> PosePath {
        let half = 0.5 * self.car.body.wheelbase_m;
        let rear = |s: &UTurnState| (s.x_m - half * s.heading_rad.cos(), s.y_m - half * s.heading_rad.sin());
        let pose = |s: &UTurnState, s_m: f64| {
            let (x_m, y_m) = rear(s);
            PathPose {
                x_m,
                y_m,
                heading_rad: s.heading_rad,
                curvature_per_m: s.wheel_angle_rad.tan() / self.car.body.wheelbase_m,
                wheel_angle_rad: s.wheel_angle_rad,
                direction: Gear::Forward,
                s_m,
            }
        };
        let step_m = if step_m >= 1e-4 { step_m } else { 1e-4 };
        let mut poses = vec![pose(&self.states[0], 0.0)];
        let (mut way_m, mut next) = (0.0, 1.0);
        for pair in self.states.windows(2) {
            let (from, to) = (rear(&pair[0]), rear(&pair[1]));
            let piece = (to.0 - from.0).hypot(to.1 - from.1);
            while piece > 0.0 && next * step_m <= way_m + piece {
                let part = (next * step_m - way_m) / piece;
                let mix = |a: f64, b: f64| a + part * (b - a);
                let state = UTurnState {
                    t_s: mix(pair[0].t_s, pair[1].t_s),
                    x_m: mix(pair[0].x_m, pair[1].x_m),
                    y_m: mix(pair[0].y_m, pair[1].y_m),
                    heading_rad: mix(pair[0].heading_rad, pair[1].heading_rad),
                    wheel_angle_rad: mix(pair[0].wheel_angle_rad, pair[1].wheel_angle_rad),
                    speed_mps: mix(pair[0].speed_mps, pair[1].speed_mps),
                };
                poses.push(pose(&state, next * step_m));
                next += 1.0;
            }
            way_m += piece;
        }
        if way_m > poses[poses.len() - 1].s_m + 1e-6 {
            poses.push(pose(&self.end(), way_m));
        }
        PosePath { poses }
    }
}

/// Largest distance of two tracks of the same turn at the same time [m], and of their ends: what the method of integration makes out.
pub fn largest_difference_m(one: &UTurnTrack, other: &UTurnTrack) -> (f64, f64) {
    let apart = |a: &UTurnState, b: &UTurnState| (a.x_m - b.x_m).hypot(a.y_m - b.y_m);
    let at = |t_s: f64| {
        let k = other.states.partition_point(|s| s.t_s < t_s).clamp(1, other.states.len() - 1);
        let (a, b) = (&other.states[k - 1], &other.states[k]);
        let part = if b.t_s > a.t_s { ((t_s - a.t_s) / (b.t_s - a.t_s)).clamp(0.0, 1.0) } else { 1.0 };
        UTurnState { x_m: a.x_m + part * (b.x_m - a.x_m), y_m: a.y_m + part * (b.y_m - a.y_m), ..*a }
    };
    let from = one.turn_from();
    let largest = one.states[from..].iter().map(|s| apart(s, &at(s.t_s))).fold(0.0, f64::max);
    (largest, apart(&one.end(), &other.end()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::BodyShape;

    fn car() -> Car {
        Car { body: BodyShape::usual(2.1), steering_ratio: 16.0, steering_limit_rad: 470.0_f64.to_radians() }
    }

    fn turn(speed_mps: f64, rate_deg_s: f64) -> UTurnShape {
        UTurnShape { run_up_m: 11.0, speed_mps, steering_rate_rad_s: rate_deg_s.to_radians() }
    }

    #[test]
    fn the_heading_turns_by_exactly_half_a_turn_and_the_wheel_ends_straight() {
        for method in [Method::Euler, Method::RungeKutta] {
            for (speed, rate) in [(0.7, 400.0), (3.4, 100.0), (6.0, 200.0), (6.0, 400.0), (6.0, 20.0)] {
                let track = drive(&car(), &turn(speed, rate), &UTurnSettings { method, ..UTurnSettings::default() }).unwrap();
                let end = track.end();
                assert!((end.heading_rad - 1.5 * PI).abs() < 1e-11, "{speed} {rate}: {}", end.heading_rad - 1.5 * PI);
                assert!(end.wheel_angle_rad.abs() < 1e-12);
                assert!(track.peak_wheel_rad <= car().wheel_limit_rad() + 1e-12);
                assert_eq!(track.phases_s[1] > 0.0, (track.peak_wheel_rad - car().wheel_limit_rad()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn slowing_down_in_the_turn_counts_and_stopping_is_an_error() {
        let slowing = UTurnSettings { turn_accel_mps2: [0.0, -0.05, 0.0], ..UTurnSettings::default() };
        let track = drive(&car(), &turn(2.0, 400.0), &slowing).unwrap();
        assert!((track.end().heading_rad - 1.5 * PI).abs() < 1e-11 && track.end().speed_mps < 1.9);
        let stopping = UTurnSettings { turn_accel_mps2: [0.0, -1.0, 0.0], ..UTurnSettings::default() };
        let Err(Error::StopsInTurn { nearest_mps, .. }) = drive(&car(), &turn(2.0, 400.0), &stopping) else { panic!() };
        assert!(drive(&car(), &UTurnShape { run_up_m: 30.0, ..turn(nearest_mps * 1.05, 400.0) }, &stopping).is_ok(), "{nearest_mps}");
    }

    #[test]
    fn a_run_up_too_short_names_the_one_that_is_not() {
        let short = UTurnShape { run_up_m: 5.0, ..turn(6.0, 200.0) };
        let Err(Error::RunUpTooShort { nearest_m, .. }) = drive(&car(), &short, &UTurnSettings::default()) else { panic!() };
        assert!((nearest_m - 6.0).abs() < 1e-12);
    }

    #[test]
    fn the_path_of_the_rear_axle_has_even_steps_and_its_own_curvature() {
        let track = drive(&car(), &turn(1.0, 200.0), &UTurnSettings { method: Method::RungeKutta, ..UTurnSettings::default() }).unwrap();
        let path = track.path(0.05);
        for pair in path.poses.windows(2).take(path.poses.len() - 2) {
            assert!((pair[1].s_m - pair[0].s_m - 0.05).abs() < 1e-9);
            let mean = 0.5 * (pair[0].curvature_per_m + pair[1].curvature_per_m);
            // a corner of the wheel angle inside the step leaves what the mean of its ends misses
            assert!((pair[1].heading_rad - pair[0].heading_rad - 0.05 * mean).abs() < 4e-4);
        }
    }
}
