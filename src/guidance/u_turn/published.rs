//! The published case: its scene and its known answers, and how a body of given dimensions meets them.
//!
//! The vehicle's dimensions are not published. [`PublishedCase::findings`] computes every answer for a body, so that the dimensions can be inferred
//! (`examples/u_turn_inference.rs`); what cannot be met is stated, not forced.

use crate::guidance::geometry::{PlanePoint, Polygon};
use crate::guidance::u_turn::model::Car;
use crate::guidance::u_turn::scene::{Lane, UTurnScene, beyond_m};
use crate::guidance::u_turn::track::{UTurnSettings, UTurnShape, UTurnTrack, drive};
use crate::guidance::{BodyShape, Result};
use serde::Serialize;

/// The yaw rate that both published pairs of entry speed and curvature have in common [rad/s]: 1.63·0.205 = 0.3342, 1.585·0.21 = 0.3329.
pub const YAW_RATE_RAD_S: f64 = 1.0 / 3.0;

/// The dimensions that meet the known answers best: `examples/u_turn_inference.rs`. The rear overhang hardly shows in them and is taken as the front
/// one.
pub const INFERRED_BODY: BodyShape = BodyShape { wheelbase_m: 2.106, width_m: 1.388, front_overhang_m: 1.203, rear_overhang_m: 1.203 };

/// The reading of the publication's words for which that holds: "just clears" and "just touches" both mean the clearance, and the run-ups are those of
/// the tightest turn.
pub const INFERRED_HYPOTHESIS: Hypothesis = Hypothesis { clears_m: 0.3, touches_m: 0.3, run_up_turn: (0.7, 400.0) };

/// Entry speed that belongs to a curvature at the published yaw rate [m/s]; infinite for a straight line.
pub fn entry_speed_mps(curvature_per_m: f64) -> f64 {
    YAW_RATE_RAD_S / curvature_per_m.abs()
}

/// A known answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
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
    /// With 400°/s at 6 m/s it ends in the outer lane.
    OuterLane,
    /// The curvatures 0.205 and 0.21 per metre are within the wheel's limit.
    CurvatureReached,
}

/// All answers about geometry, in the order of the publication's list.
pub const ANSWERS: [Answer; 7] = [
    Answer::CurvatureReached,
    Answer::ShortestRunUp,
    Answer::LongestRunUp,
    Answer::MiddleLane,
    Answer::OuterLane,
    Answer::ClearsBorder,
    Answer::TouchesInnerLine,
];

/// What the words of the publication leave open.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Hypothesis {
    /// Distance of the body from the border that "just clears" means [m]: 0 or the clearance.
    pub clears_m: f64,
    /// Distance of the body from the line that "just touches" means [m]: 0 or the clearance.
    pub touches_m: f64,
    /// Speed [m/s] and steering rate [°/s] of the turn whose run-up is between the shortest and the longest.
    pub run_up_turn: (f64, f64),
}

/// One answer computed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PublishedFinding {
    /// Which.
    pub answer: Answer,
    /// Computed less published [m]; for a lane or the curvature how much is lacking, 0 when it is met.
    pub residual_m: f64,
    /// Lane in which the turn ends, where that is the question.
    pub lane: Option<Lane>,
}

impl PublishedFinding {
    /// Whether the answer is met to `within_m`.
    pub fn met(&self, within_m: f64) -> bool {
        self.residual_m.abs() <= within_m
    }
}

/// The published scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PublishedCase {
    /// Field, obstacle, lane lines, clearance.
    pub scene: UTurnScene,
}

impl PublishedCase {
    /// The scene as published.
    ///
    /// # Errors
    /// None: the published corners are convex.
    pub fn new() -> Result<Self> {
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
    pub fn car(body: BodyShape) -> Car {
        Car { body, steering_ratio: 16.0, steering_limit_rad: 470.0_f64.to_radians() }
    }

    /// The published turn of a speed [m/s] and a steering rate [°/s] after a run-up [m].
    ///
    /// # Errors
    /// A turn that cannot be driven.
    pub fn track(body: BodyShape, run_up_m: f64, speed_mps: f64, rate_deg_s: f64, settings: &UTurnSettings) -> Result<UTurnTrack> {
        drive(&Self::car(body), &UTurnShape { run_up_m, speed_mps, steering_rate_rad_s: rate_deg_s.to_radians() }, settings)
    }

    /// Shortest and longest run-up of a turn that keep the clearance [m].
    ///
    /// # Errors
    /// A turn that cannot be driven.
    pub fn run_ups(&self, body: BodyShape, (speed_mps, rate_deg_s): (f64, f64), settings: &UTurnSettings) -> Result<[f64; 2]> {
        const FROM_M: f64 = 11.0;
        let track = Self::track(body, FROM_M, speed_mps, rate_deg_s, settings)?;
        let clearance_m = self.scene.clearance_m;
        let clear = |run_up: f64| self.scene.margins(&track, run_up - FROM_M, 3);
        let shortest = {
            // from where it is certainly clear back to where it is not any more
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
    pub fn findings(&self, body: BodyShape, hypothesis: &Hypothesis, settings: &UTurnSettings) -> Result<Vec<PublishedFinding>> {
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

    /// How far the body at the end of a track is out of a lane [m]; 0 inside.
    fn out_of_lane_m(&self, track: &UTurnTrack, lane: usize) -> f64 {
        let body = track.body(&track.end());
        let past_inner = if lane > 0 { -beyond_m(self.scene.lines[lane - 1], &body).0 } else { 0.0 };
        let past_outer = self.scene.lines.get(lane).map_or(0.0, |&line| beyond_m(line, &body).1);
        past_inner.max(past_outer).max(0.0)
    }
}

/// The place between `bad` and `good` from which on `clear` holds.
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_inferred_body_meets_every_length_and_no_body_can_meet_the_lanes() {
        let case = PublishedCase::new().unwrap();
        let findings = case.findings(INFERRED_BODY, &INFERRED_HYPOTHESIS, &UTurnSettings::default()).unwrap();
        for finding in &findings {
            match finding.answer {
                // the published lanes are the other way round: the slower wheel makes the wider turn, whatever the dimensions
                Answer::MiddleLane => assert_eq!(finding.lane, Some(Lane::Number(2))),
                Answer::OuterLane => assert_eq!(finding.lane, Some(Lane::Number(1))),
                // four answers, three dimensions: 1 cm on lengths of 10 m and more
                _ => assert!(finding.met(0.01), "{finding:?}"),
            }
        }
    }

    #[test]
    fn a_slower_wheel_always_turns_wider() {
        for wheelbase_m in [1.5, 2.1, 2.7] {
            let body = BodyShape { wheelbase_m, ..INFERRED_BODY };
            let width = |rate| -PublishedCase::track(body, 11.0, 6.0, rate, &UTurnSettings::default()).unwrap().end().x_m;
            assert!(width(200.0) > width(400.0) + 1.0);
        }
    }

    #[test]
    fn the_published_pairs_share_their_yaw_rate_and_neither_their_lateral_acceleration() {
        for (speed, curvature) in [(1.63, 0.205), (1.585, 0.21)] {
            // the curvature has three digits: 0.0005 of 0.205
            assert!((entry_speed_mps(curvature) / speed - 1.0_f64).abs() < 0.0025);
        }
        let lateral = [1.63_f64 * 1.63 * 0.205, 1.585 * 1.585 * 0.21];
        assert!(lateral[0] / lateral[1] > 1.03, "3 % apart, where the digits allow 0.6 %");
    }

    #[test]
    fn euler_stays_within_the_way_of_two_steps_of_the_higher_order() {
        for (speed, rate) in [(0.7, 400.0), (3.4, 100.0), (6.0, 200.0), (6.0, 400.0)] {
            let of = |method| {
                PublishedCase::track(INFERRED_BODY, 11.0, speed, rate, &UTurnSettings { method, ..UTurnSettings::default() }).unwrap()
            };
            let (euler, higher) = (of(crate::guidance::u_turn::Method::Euler), of(crate::guidance::u_turn::Method::RungeKutta));
            let (along_m, end_m) = crate::guidance::u_turn::largest_difference_m(&euler, &higher);
            // each step goes where the vehicle looked at its start: half a step late all the way, which over half a turn adds up to two steps' way;
            // 2 % for the terms of second order
            assert!(along_m <= 1.02 * 2.0 * 0.01 * speed && end_m <= along_m + 1e-9, "{speed} m/s: {along_m} {end_m}");
        }
    }
}
