//! The published U-turn: which of its known answers the inferred body meets.
#![allow(clippy::unwrap_used)]

#[path = "../examples/u_turn_inference/published.rs"]
mod published;

use pivot_cal::internals::BodyShape;
use pivot_cal::internals::u_turn::{Lane, Method, Ranges, UTurnSettings, largest_difference_m, search};
use published::{Answer, FullLock, Hypothesis, INFERRED_BODY, INFERRED_HYPOTHESIS, PublishedCase, entry_speed_mps};

#[test]
fn the_inferred_body_meets_every_length_with_the_turn_of_one_figure_and_misses_by_half_a_metre_with_the_turn_that_is_named() {
    let case = PublishedCase::new().unwrap();
    let settings = UTurnSettings::default();
    let findings = case.findings(INFERRED_BODY, &INFERRED_HYPOTHESIS, &settings).unwrap();
    for finding in &findings {
        match finding.answer {
            // the slower wheel makes the wider turn, whatever the dimensions
            Answer::MiddleLane => assert_eq!(finding.lane, Some(Lane::Number(2))),
            // one caption has the outer lane, which is missed, another one the middle lane, which is met
            Answer::OuterLane => assert_eq!(finding.lane, Some(Lane::Number(1))),
            // four answers, three dimensions: 1 cm on lengths of 10 m and more
            _ => assert!(finding.met(0.01), "{finding:?}"),
        }
    }
    let named = Hypothesis { run_up_turn: (1.63, 400.0), ..INFERRED_HYPOTHESIS };
    let run_ups = case.run_ups(INFERRED_BODY, named.run_up_turn, &settings).unwrap();
    let missed = [run_ups[0] - 10.0150, run_ups[1] - 21.6913];
    assert!(missed.iter().all(|m| (0.3..0.8).contains(&m.abs())), "{missed:?}");
}

#[test]
fn the_published_times_leave_too_little_for_the_run_up_and_the_largest_speed_just_touches_the_border() {
    let case = PublishedCase::new().unwrap();
    let track = PublishedCase::track(INFERRED_BODY, 11.0, 6.0, 200.0, &UTurnSettings::default()).unwrap();
    let left_s = 6.18 - track.phases_s.iter().sum::<f64>();
    // both published tracks end at 6.18 s; 6 m/s from rest at 3 m/s² takes 2 s
    assert!((left_s - 1.74).abs() < 0.02 && left_s < 2.0, "{left_s}");
    let largest_mps = case.largest_speed_mps(INFERRED_BODY, 400.0).unwrap();
    assert!((largest_mps / 10.0519 - 1.0).abs() < 0.001, "{largest_mps}");
}

#[test]
fn a_wheel_that_does_not_hold_puts_both_tracks_into_the_middle_lane_and_breaks_the_fourth_figure() {
    let case = PublishedCase::new().unwrap();
    let slow = FullLock::drive(INFERRED_BODY, 11.0, 6.0, 200.0);
    assert!((slow.turned_deg - 202.2).abs() < 0.1, "{}", slow.turned_deg);
    assert_eq!(case.lane_of(slow.bodies.last().unwrap()), Some(1));
    // in and out alone turn by less than 180°: the wheel holds, as in every reading
    assert!(FullLock::drive(INFERRED_BODY, 11.0, 6.0, 400.0).turned_deg < 180.0);
    let fast = PublishedCase::track(INFERRED_BODY, 11.0, 6.0, 400.0, &UTurnSettings::default()).unwrap();
    assert_eq!(case.scene.lane(&fast, 0.0).0, Lane::Number(1));
    // the figure in which 3.4 m/s with 100°/s just clears the border by 0.3 m
    let border = FullLock::drive(INFERRED_BODY, 11.0, 3.4, 100.0);
    let least_m = border.bodies.iter().map(|body| case.scene.field.inside_margin_m(body)).fold(f64::INFINITY, f64::min);
    assert!(border.turned_deg > 220.0 && (least_m - 0.3).abs() > 0.2, "{} {least_m}", border.turned_deg);
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
