//! The published case: its scene, its known answers, and the deviations of a body of given dimensions from them.
//!
//! The vehicle's dimensions are not published. [`PublishedCase::findings`] computes every answer for a body, so that the dimensions can be inferred
//! (`examples/u_turn_inference.rs`); an answer that cannot be met is reported, not forced.
//!
//! The answers contradict one another: the run-ups are said to be those of the least entry speed, 1.63 m/s with 400°/s, and one figure has
//! 0.7 m/s, which is below it. `docs/manoeuvres.md` lists what is met, what contradicts itself, and what no reading meets.

#![allow(dead_code)] // the test and the example use different parts

use pivot_cal::internals::u_turn::{Car, Lane, UTurnScene, UTurnSettings, UTurnShape, UTurnTrack, beyond_m, drive};
use pivot_cal::internals::{BodyShape, PlanePoint, Polygon};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// The yaw rate that both published pairs of entry speed and curvature have in common [rad/s]: 1.63·0.205 = 0.3342, 1.585·0.21 = 0.3329.
pub(crate) const YAW_RATE_RAD_S: f64 = 1.0 / 3.0;

/// The dimensions that meet the known answers best: `examples/u_turn_inference.rs`. The rear overhang hardly affects them and is set to the
/// front one.
pub(crate) const INFERRED_BODY: BodyShape =
    BodyShape { wheelbase_m: 2.106, width_m: 1.388, front_overhang_m: 1.203, rear_overhang_m: 1.203 };

/// The interpretation of the publication's words for which that holds: "just clears" and "just touches" both mean the clearance, and the
/// run-ups are those of the tightest turn, 0.7 m/s with 400°/s. The publication names 1.63 m/s with 400°/s for them instead, which this body
/// misses by half a metre.
pub(crate) const INFERRED_HYPOTHESIS: Hypothesis = Hypothesis { clears_m: 0.3, touches_m: 0.3, run_up_turn: (0.7, 400.0) };

/// Entry speed that belongs to a curvature at the published yaw rate [m/s]; infinite for a straight line.
pub(crate) fn entry_speed_mps(curvature_per_m: f64) -> f64 {
    YAW_RATE_RAD_S / curvature_per_m.abs()
}

/// A known answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Answer {
    /// 3.4 m/s with 100°/s after 11 m just clears the border.
    ClearsBorder,
    /// 0.7 m/s with 400°/s after 11 m just touches the inner line.
    TouchesInnerLine,
    /// Shortest run-up, 10.0150 m.
    ShortestRunUp,
    /// Longest run-up, 21.6913 m.
    LongestRunUp,
    /// With 200°/s at 6 m/s it ends in the middle lane.
    MiddleLane,
    /// With 400°/s at 6 m/s it ends in the outer lane: by one caption; by another one it is the middle lane, which is met.
    OuterLane,
    /// The curvatures 0.205 and 0.21 per metre are within the wheel's limit.
    CurvatureReached,
}

/// All answers about geometry, in the order of the publication's list.
pub(crate) const ANSWERS: [Answer; 7] = [
    Answer::CurvatureReached,
    Answer::ShortestRunUp,
    Answer::LongestRunUp,
    Answer::MiddleLane,
    Answer::OuterLane,
    Answer::ClearsBorder,
    Answer::TouchesInnerLine,
];

/// Interpretation of words that the publication does not define.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hypothesis {
    /// Distance of the body from the border that "just clears" means [m]: 0 or the clearance.
    pub(crate) clears_m: f64,
    /// Distance of the body from the line that "just touches" means [m]: 0 or the clearance.
    pub(crate) touches_m: f64,
    /// Speed [m/s] and steering rate [°/s] of the turn whose run-up is between the shortest and the longest.
    pub(crate) run_up_turn: (f64, f64),
}

/// One computed answer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PublishedFinding {
    /// The answer.
    pub(crate) answer: Answer,
    /// Computed minus published [m]; for a lane or the curvature the shortfall, 0 when it is met.
    pub(crate) residual_m: f64,
    /// Lane in which the turn ends, for answers about lanes.
    pub(crate) lane: Option<Lane>,
}

impl PublishedFinding {
    /// Whether the answer is met to `within_m`.
    pub(crate) fn met(&self, within_m: f64) -> bool {
        self.residual_m.abs() <= within_m
    }
}

/// The published scene.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PublishedCase {
    /// Field, obstacle, lane lines, clearance.
    pub(crate) scene: UTurnScene,
}

impl PublishedCase {
    /// The published scene.
    ///
    /// # Errors
    /// None: the published corners are convex.
    pub(crate) fn new() -> Fallible<Self> {
        let p = PlanePoint::new;
        Ok(Self {
            scene: UTurnScene {
                field: Polygon::new(vec![p(1.5024, -4.9270), p(1.5024, 26.5489), p(-13.5194, 27.6157), p(-13.4342, -5.3108)])?,
                obstacles: vec![Polygon::new(vec![p(-1.5024, -5.0730), p(-1.4853, 10.9527), p(-3.0210, 10.7992), p(-2.9785, -5.6640)])?],
                lines: vec![(p(-6.5063, 10.9170), p(-6.4637, -5.5463)), (p(-9.9915, 11.0347), p(-9.9489, -5.4286))],
                clearance_m: 0.3,
            },
        })
    }

    /// The published steering on a body.
    pub(crate) fn car(body: BodyShape) -> Car {
        Car { body, steering_ratio: 16.0, steering_limit_rad: 470.0_f64.to_radians() }
    }

    /// The published turn of a speed [m/s] and a steering rate [°/s] after a run-up [m].
    ///
    /// # Errors
    /// A turn that cannot be driven.
    pub(crate) fn track(body: BodyShape, run_up_m: f64, speed_mps: f64, rate_deg_s: f64, settings: &UTurnSettings) -> Fallible<UTurnTrack> {
        Ok(drive(&Self::car(body), &UTurnShape { run_up_m, speed_mps, steering_rate_rad_s: rate_deg_s.to_radians() }, settings)?)
    }

    /// Shortest and longest run-up of a turn that keep the clearance [m].
    ///
    /// # Errors
    /// A turn that cannot be driven.
    pub(crate) fn run_ups(&self, body: BodyShape, (speed_mps, rate_deg_s): (f64, f64), settings: &UTurnSettings) -> Fallible<[f64; 2]> {
        const FROM_M: f64 = 11.0;
        let track = Self::track(body, FROM_M, speed_mps, rate_deg_s, settings)?;
        let clearance_m = self.scene.clearance_m;
        let clear = |run_up: f64| self.scene.margins(&track, run_up - FROM_M, 3);
        let shortest = {
            // from a shift that is certainly clear back to one that is not
            let mut high = 16.0;
            while high > 0.0 && clear(high - 0.5).obstacle_m >= clearance_m {
                high -= 0.5;
            }
            bisect(high - 0.5, high, |r| clear(r).obstacle_m >= clearance_m)
        };
        let longest = bisect(40.0, FROM_M, |r| clear(r).border_m >= clearance_m);
        Ok([shortest, longest])
    }

    /// Every answer for a body.
    ///
    /// # Errors
    /// A turn that cannot be driven.
    pub(crate) fn findings(&self, body: BodyShape, hypothesis: &Hypothesis, settings: &UTurnSettings) -> Fallible<Vec<PublishedFinding>> {
        let track = |run_up, speed, rate| Self::track(body, run_up, speed, rate, settings);
        let [shortest, longest] = self.run_ups(body, hypothesis.run_up_turn, settings)?;
        let car = Self::car(body);
        ANSWERS
            .into_iter()
            .map(|answer| {
                let mut lane = None;
                let residual_m = match answer {
                    Answer::ClearsBorder => self.scene.margins(&track(11.0, 3.4, 100.0)?, 0.0, 1).border_m - hypothesis.clears_m,
                    Answer::TouchesInnerLine => {
                        let track = track(11.0, 0.7, 400.0)?;
                        beyond_m(self.scene.lines[0], &track.body(&track.end())).0 - hypothesis.touches_m
                    }
                    Answer::ShortestRunUp => shortest - 10.0150,
                    Answer::LongestRunUp => longest - 21.6913,
                    Answer::MiddleLane | Answer::OuterLane => {
                        let (rate, wanted) = if answer == Answer::MiddleLane { (200.0, 1) } else { (400.0, 2) };
                        let track = track(11.0, 6.0, rate)?;
                        lane = Some(self.scene.lane(&track, 0.0).0);
                        self.out_of_lane_m(&track, wanted)
                    }
                    Answer::CurvatureReached => (0.21 - car.curvature_per_m(car.wheel_limit_rad())).max(0.0),
                };
                Ok(PublishedFinding { answer, residual_m, lane })
            })
            .collect()
    }

    /// The largest speed [m/s] after a run-up no longer than reaching it takes at which the turn with a steering rate [°/s] just touches the
    /// field's border.
    ///
    /// # Errors
    /// A turn that cannot be driven.
    pub(crate) fn largest_speed_mps(&self, body: BodyShape, rate_deg_s: f64) -> Fallible<f64> {
        let settings = UTurnSettings::default();
        let margin_m = |speed_mps: f64| -> Fallible<f64> {
            let run_up_m = 0.5 * speed_mps * speed_mps / settings.run_up_accel_mps2 + 1e-9;
            Ok(self.scene.margins(&Self::track(body, run_up_m, speed_mps, rate_deg_s, &settings)?, 0.0, 1).border_m)
        };
        let (mut low, mut high) = (5.0, 14.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if margin_m(middle)? > 0.0 { low = middle } else { high = middle }
        }
        Ok(low)
    }

    /// The lane in which a body stands; `None` on a line.
    pub(crate) fn lane_of(&self, body: &Polygon) -> Option<usize> {
        let beyond = self.scene.lines.iter().map(|line| beyond_m(*line, body));
        if beyond.clone().any(|(near, far)| near <= 0.0 && far >= 0.0) { None } else { Some(beyond.filter(|b| b.0 > 0.0).count()) }
    }

    /// Distance of the body outside a lane at the end of a track [m]; 0 inside.
    fn out_of_lane_m(&self, track: &UTurnTrack, lane: usize) -> f64 {
        let body = track.body(&track.end());
        let past_inner = if lane > 0 { -beyond_m(self.scene.lines[lane - 1], &body).0 } else { 0.0 };
        let past_outer = self.scene.lines.get(lane).map_or(0.0, |&line| beyond_m(line, &body).1);
        past_inner.max(past_outer).max(0.0)
    }
}

/// A turn in which the wheel goes to its full lock and back without holding, whatever the heading at the end: ψ₂ = max(0, 180° − ψ₁ − ψ₃) where
/// ψ₁ + ψ₃ is more than 180°. Where it is less, the wheel holds, and the turn is the usual one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FullLock {
    /// Angle by which the heading has turned [°].
    pub(crate) turned_deg: f64,
    /// The body after every step.
    pub(crate) bodies: Vec<Polygon>,
}

impl FullLock {
    /// After a run-up [m], at a speed [m/s] with a steering rate [°/s], by Euler's method with 0.01 s.
    pub(crate) fn drive(body: BodyShape, run_up_m: f64, speed_mps: f64, rate_deg_s: f64) -> Self {
        const STEP_S: f64 = 0.01;
        let car = PublishedCase::car(body);
        let (limit_rad, rate_rad_s) = (car.wheel_limit_rad(), rate_deg_s.to_radians() / car.steering_ratio);
        let full_s = limit_rad / rate_rad_s;
        let half_m = 0.5 * body.wheelbase_m;
        let mut bodies = Vec::new();
        let (mut x, mut y, mut heading, mut t): (f64, f64, f64, f64) = (0.0, run_up_m, std::f64::consts::FRAC_PI_2, 0.0);
        while t < 2.0 * full_s {
            let step_s = STEP_S.min(2.0 * full_s - t);
            let wheel = rate_rad_s * t.min(2.0 * full_s - t);
            let slip = (0.5 * wheel.tan()).atan();
            x += step_s * speed_mps * (heading + slip).cos();
            y += step_s * speed_mps * (heading + slip).sin();
            heading += step_s * speed_mps * slip.cos() * wheel.tan() / body.wheelbase_m;
            t += STEP_S;
            bodies.push(body.at(x - half_m * heading.cos(), y - half_m * heading.sin(), heading));
        }
        let turned_deg = (heading - std::f64::consts::FRAC_PI_2).to_degrees();
        Self { turned_deg, bodies }
    }
}

/// The place between `bad` and `good` where `clear` begins to hold.
fn bisect(mut bad: f64, mut good: f64, clear: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..26 {
        let middle = 0.5 * (bad + good);
        if clear(middle) {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}
