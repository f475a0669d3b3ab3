//! The search for the U-turn with the largest margin.
//!
//! The track of a speed and a wheel rate has the same shape for every run-up and is only shifted. So each pair is driven once and shifted.
//! The pairs form a grid, which is then contracted around the best pair several times.

use crate::guidance::body::within;
use crate::guidance::u_turn::model::Car;
use crate::guidance::u_turn::scene::{Margins, UTurnScene};
use crate::guidance::u_turn::track::{UTurnSettings, UTurnShape, UTurnTrack, drive};
use crate::guidance::{Error, Result};
use serde::Serialize;

/// Ranges of the search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ranges {
    /// Run-up, least and largest [m].
    pub run_up_m: [f64; 2],
    /// Speed, least and largest [m/s].
    pub speed_mps: [f64; 2],
    /// Rate of the steering wheel, least and largest [rad/s].
    pub steering_rate_rad_s: [f64; 2],
    /// Largest yaw rate in the turn [rad/s]; `None`, the default, sets no limit.
    pub yaw_rate_rad_s: Option<f64>,
}

/// Result of the search.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundUTurn {
    /// The turn.
    pub turn: UTurnShape,
    /// Its margins.
    pub margins: Margins,
    /// Its track.
    pub track: UTurnTrack,
    /// Number of evaluated turns.
    pub tried: usize,
}

/// Points of the grid along speed and wheel rate.
const GRID: usize = 7;
/// Number of contractions of the grid, each to a third.
const ROUNDS: usize = 5;
/// Number of run-ups per pair.
const RUN_UPS: usize = 24;

/// Searches for the turn with the largest margin from border and obstacles that ends off every lane line.
///
/// # Errors
/// A range out of order or not finite; a turn that cannot be driven; no turn that keeps the scene's clearance, with the best and its
/// shortfall.
pub fn search(car: &Car, scene: &UTurnScene, ranges: &Ranges, settings: &UTurnSettings) -> Result<FoundUTurn> {
    for (field, [low, high]) in
        [("run_up_m", ranges.run_up_m), ("speed_mps", ranges.speed_mps), ("steering_rate_rad_s", ranges.steering_rate_rad_s)]
    {
        within(field, low, 0.0, 1000.0, "0 to 1000")?;
        within(field, high, low, 1000.0, "the range's lower end to 1000")?;
    }
    let car = car.checked()?;
    let mut best: Option<FoundUTurn> = None;
    let mut tried = 0;
    let (mut speeds, mut rates) = (ranges.speed_mps, ranges.steering_rate_rad_s);
    for _ in 0..ROUNDS {
        for i in 0..GRID {
            for j in 0..GRID {
                let speed_mps = mix(speeds, i);
                let steering_rate_rad_s = mix(rates, j);
                let yaw_rate = speed_mps * car.curvature_per_m(car.wheel_limit_rad());
                if ranges.yaw_rate_rad_s.is_some_and(|limit| yaw_rate > limit) {
                    continue;
                }
                let rising_m = 0.5 * speed_mps * speed_mps / settings.run_up_accel_mps2;
                let low = ranges.run_up_m[0].max(rising_m);
                if low > ranges.run_up_m[1] {
                    continue;
                }
                let track = drive(&car, &UTurnShape { run_up_m: low, speed_mps, steering_rate_rad_s }, settings)?;
                let (shift_m, margins) = best_shift(scene, &track, ranges.run_up_m[1] - low);
                tried += RUN_UPS;
                if best.as_ref().is_none_or(|b| better(&margins, &b.margins)) {
                    let turn = UTurnShape { run_up_m: low + shift_m, speed_mps, steering_rate_rad_s };
                    best = Some(FoundUTurn { turn, margins, track, tried });
                }
            }
        }
        let Some(found) = &best else { break };
        speeds = drawn_together(speeds, found.turn.speed_mps);
        rates = drawn_together(rates, found.turn.steering_rate_rad_s);
    }
    let Some(mut found) = best else {
        let nearest_m = 0.5 * ranges.speed_mps[0].powi(2) / settings.run_up_accel_mps2;
        let (speed_mps, run_up_m) = (ranges.speed_mps[0], ranges.run_up_m[1]);
        return Err(Error::RunUpTooShort { speed_mps, run_up_m, accel_mps2: settings.run_up_accel_mps2, nearest_m });
    };
    found.track = drive(&car, &found.turn, settings)?;
    found.margins = scene.margins(&found.track, 0.0, 1);
    found.tried = tried;
    let margin_m = found.margins.smallest_m();
    if margin_m >= scene.clearance_m && found.margins.line_m > 0.0 {
        return Ok(found);
    }
    let turn = &found.turn;
    Err(Error::NoUTurn {
        clearance_m: scene.clearance_m,
        best: format!(
            "{:.2} m of run-up, {:.2} m/s, {:.0}°/s, {:.3} m from the border, {:.3} m from the obstacles, {:.3} m from a lane line",
            turn.run_up_m,
            turn.speed_mps,
            turn.steering_rate_rad_s.to_degrees(),
            found.margins.border_m,
            found.margins.obstacle_m,
            found.margins.line_m
        ),
        lacking_m: (scene.clearance_m - margin_m).max(-found.margins.line_m).max(0.0),
        nearest_m: margin_m,
    })
}

/// A track that ends off every line is preferred to one that does not; then the larger margin.
fn better(one: &Margins, other: &Margins) -> bool {
    let key = |m: &Margins| (m.line_m > 0.0, m.smallest_m());
    let ((free, margin), (other_free, other_margin)) = (key(one), key(other));
    if free == other_free { margin > other_margin } else { free }
}

fn mix([low, high]: [f64; 2], k: usize) -> f64 {
    low + (high - low) * k as f64 / (GRID - 1) as f64
}

/// A third of the range, around `middle`, within the range.
fn drawn_together([low, high]: [f64; 2], middle: f64) -> [f64; 2] {
    let half = (high - low) / 6.0;
    [(middle - half).max(low), (middle + half).min(high)]
}

/// The shift of the track, up to `most_m`, with the largest margin: scan, then contraction.
fn best_shift(scene: &UTurnScene, track: &UTurnTrack, most_m: f64) -> (f64, Margins) {
    let (mut low, mut high) = (0.0, most_m);
    let mut best = (0.0, scene.margins(track, 0.0, 8));
    for _ in 0..3 {
        let step = (high - low) / RUN_UPS as f64;
        for k in 0..=RUN_UPS {
            let shift_m = low + step * k as f64;
            let margins = scene.margins(track, shift_m, 8);
            if better(&margins, &best.1) {
                best = (shift_m, margins);
            }
        }
        (low, high) = ((best.0 - step).max(0.0), (best.0 + step).min(most_m));
    }
    best
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::{BodyShape, PlanePoint, Polygon};
    use proptest::prelude::*;

    fn aisle(right_m: f64) -> (Car, UTurnScene, Ranges, UTurnSettings) {
        let rectangle = |x0, x1, y0, y1| {
            Polygon::new(vec![PlanePoint::new(x0, y0), PlanePoint::new(x1, y0), PlanePoint::new(x1, y1), PlanePoint::new(x0, y1)]).unwrap()
        };
        let car = Car { body: BodyShape::usual(0.9), steering_ratio: 1.0, steering_limit_rad: 60.0_f64.to_radians() };
        let scene = UTurnScene {
            field: rectangle(-3.2, right_m, -1.2, 6.5),
            obstacles: vec![rectangle(-1.6, -0.8, -1.2, 3.4)],
            lines: Vec::new(),
            clearance_m: 0.3,
        };
        let ranges = Ranges { run_up_m: [1.0, 5.5], speed_mps: [0.3, 0.8], steering_rate_rad_s: [0.2, 0.7], yaw_rate_rad_s: None };
        (car, scene, ranges, UTurnSettings { run_up_accel_mps2: 0.5, step_s: 0.02, ..UTurnSettings::default() })
    }

    #[test]
    fn the_best_turn_is_no_worse_than_an_even_grid_of_turns() {
        let (car, scene, ranges, settings) = aisle(0.8);
        let found = search(&car, &scene, &ranges, &settings).unwrap();
        let margin_m = found.margins.smallest_m();
        // 0.8 m of aisle on either side, 0.36 m of it the vehicle's half: no turn can have more than 0.44 m
        assert!((0.3..=0.44 + 1e-9).contains(&margin_m), "{:?} {:?}", found.turn, found.margins);
        // and an even grid of the whole space has no better turn
        for speed in 0..5 {
            for rate in 0..6 {
                let (speed_mps, steering_rate_rad_s) = (0.3 + 0.125 * f64::from(speed), 0.2 + 0.1 * f64::from(rate));
                let track = drive(&car, &UTurnShape { run_up_m: 1.0, speed_mps, steering_rate_rad_s }, &settings).unwrap();
                let best = (0..=45).map(|k| scene.margins(&track, 0.1 * f64::from(k), 2).smallest_m()).fold(f64::MIN, f64::max);
                assert!(best <= margin_m + 0.01, "{best} at {speed_mps} m/s, {steering_rate_rad_s} rad/s; found {margin_m}");
            }
        }
    }

    #[test]
    fn an_impossible_turn_names_the_clearance_that_is_possible() {
        let (car, mut scene, ranges, settings) = aisle(0.8);
        scene.clearance_m = 0.6;
        let Err(Error::NoUTurn { nearest_m, .. }) = search(&car, &scene, &ranges, &settings) else { panic!() };
        scene.clearance_m = nearest_m;
        assert!(search(&car, &scene, &ranges, &settings).is_ok());
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![4 => 0.0..8.0f64, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn no_turn_panics_and_every_track_keeps_its_limits(run_up_m in number(), speed_mps in number(), steering_rate_rad_s in number(), accel in number()) {
            let (car, _, _, settings) = aisle(0.8);
            let settings = UTurnSettings { step_s: 0.05, turn_accel_mps2: [0.0, -0.01 * accel, 0.0], ..settings };
            if let Ok(track) = drive(&car, &UTurnShape { run_up_m, speed_mps, steering_rate_rad_s }, &settings) {
                prop_assert!(track.states.iter().all(|s| s.wheel_angle_rad.abs() <= car.wheel_limit_rad() + 1e-9));
                prop_assert!((track.end().heading_rad - 1.5 * std::f64::consts::PI).abs() < 1e-6);
            }
        }
    }
}
