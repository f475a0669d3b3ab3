//! The published U-turn: which of its known answers the inferred body meets.
#![allow(clippy::unwrap_used)]

#[path = "common/published_u_turn.rs"]
mod published_u_turn;

use pivot_cal::internals::BodyShape;
use pivot_cal::internals::u_turn::{Lane, Method, Ranges, UTurnSettings, largest_difference_m, search};
use published_u_turn::{Answer, INFERRED_BODY, INFERRED_HYPOTHESIS, PublishedCase, entry_speed_mps};

#[test]
fn the_inferred_body_meets_every_length_and_no_body_can_meet_the_lanes() {
    let case = PublishedCase::new().unwrap();
    let findings = case.findings(INFERRED_BODY, &INFERRED_HYPOTHESIS, &UTurnSettings::default()).unwrap();
    for finding in &findings {
        match finding.answer {
            // the published lanes are the reverse: the slower wheel makes the wider turn, whatever the dimensions
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
        let of =
            |method| PublishedCase::track(INFERRED_BODY, 11.0, speed, rate, &UTurnSettings { method, ..UTurnSettings::default() }).unwrap();
        let (euler, higher) = (of(Method::Euler), of(Method::RungeKutta));
        let (along_m, end_m) = largest_difference_m(&euler, &higher);
        // each step uses the heading at its start: half a step late throughout, which over half a turn adds up to two steps' distance;
        // 2 % for the terms of second order
        assert!(along_m <= 1.02 * 2.0 * 0.01 * speed && end_m <= along_m + 1e-9, "{speed} m/s: {along_m} {end_m}");
    }
}

#[test]
fn the_published_scene_has_a_turn_that_clears_everything_and_ends_in_a_lane() {
    let case = PublishedCase::new().unwrap();
    let car = PublishedCase::car(INFERRED_BODY);
    let ranges =
        Ranges { run_up_m: [8.0, 24.0], speed_mps: [0.5, 6.0], steering_rate_rad_s: [1.0, 400.0_f64.to_radians()], yaw_rate_rad_s: None };
    let settings = UTurnSettings { step_s: 0.02, ..UTurnSettings::default() };
    let found = search(&car, &case.scene, &ranges, &settings).unwrap();
    assert!(found.margins.smallest_m() > 0.5 && found.margins.line_m > 0.0, "{:?} {:?}", found.turn, found.margins);
}
