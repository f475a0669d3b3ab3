//! The plan: straight in if the start allows it. Otherwise start and adjust on the first line, and enter on the circle. Where no single entry ends
//! straight: enter as far as there is room, and shuffle on the axis. In reverse, or nose in.

use crate::guidance::look_ahead::{LookAheadFollower, finite_start};
use crate::guidance::parking::ParkingScene;
use crate::guidance::parking::entry::{SlotEntry, entry_circle};
use crate::guidance::parking::method::{EntryMethod, StraightIn};
use crate::guidance::parking::parked_path::{ParkingPlan, axis_from, finish, follower, on_line};
use crate::guidance::parking::stage::{ParkingStage, StageSpan};
use crate::guidance::parking::start::ParkingStart;
use crate::guidance::parking::tight::shuffled;
use crate::guidance::reference::ReferenceLine;
use crate::guidance::{Error, PlanePoint, Result};
use crate::map::Gear;
use std::f64::consts::PI;

/// Radii that are tried, as factors of the smallest: a larger circle may avoid the other obstacles.
const RADII: [f64; 7] = [1.0, 1.05, 1.1, 1.2, 1.35, 1.5, 1.75];

/// Plans from `start`.
///
/// # Errors
/// A scene or start with a number out of range; a slot too small; a radius too large for it; no path that passes the checks. Each names the nearest
/// feasible parameter.
pub(crate) fn plan(scene: &ParkingScene, start: ParkingStart) -> Result<ParkingPlan> {
    let scene = scene.clone().checked()?;
    finite_start(start.x_m, start.y_m, start.heading_rad)?;
    finite_start(0.0, 0.0, start.wheel_angle_rad)?;
    let scene = scene.with_line_for(start);
    if let StraightIn::Thresholds { .. } = scene.method.straight_in
        && let Some(plan) = direct(&scene, start)
    {
        return if plan.judgement.pass {
            Ok(plan)
        } else {
            Err(no_path(start, &plan, "with other thresholds for going straight in".to_owned()))
        };
    }
    let entry = entry_circle(&scene);
    let grown = scene.method.entry == EntryMethod::GrownRadius;
    let tried = entry.as_ref().ok().filter(|_| grown).map(|entry| attempt(&scene, start, entry));
    if let Some((plan, true)) = tried {
        return Ok(plan);
    }
    if let Some(plan) = shuffled(&scene, start) {
        return Ok(plan);
    }
    let entry = entry?;
    let (best, _) = attempt(&scene, start, &entry);
    // the nearest feasible start toward the first line
    let nearer = |share: f64| ParkingStart {
        x_m: start.x_m,
        y_m: start.y_m + share * (scene.line_m() - start.y_m),
        heading_rad: start.heading_rad * (1.0 - share),
        wheel_angle_rad: start.wheel_angle_rad * (1.0 - share),
    };
    let feasible = (1..=10).map(|k| nearer(0.1 * f64::from(k))).find(|s| attempt(&scene, *s, &entry).1);
    if feasible.is_none()
        && let Some(nearest_m) = nearest_aisle_m(&scene, nearer(1.0), &entry)
    {
        return Err(Error::AisleTooNarrow { found_m: scene.slot.aisle_m, nearest_m });
    }
    if feasible.is_none()
        && let Some(nearest_m) = nearest_slot_m(&scene, nearer(1.0))
    {
        return Err(Error::SlotTooNarrowToEnter { found_m: scene.slot.width_m, nearest_m });
    }
    let nearest = feasible.map_or("no start with this x".to_owned(), |s| {
        format!("a start at y {:.2} m with heading {:.1}°", s.y_m, s.heading_rad.to_degrees())
    });
    Err(no_path(start, &best, nearest))
}

fn no_path(start: ParkingStart, best: &ParkingPlan, nearest: String) -> Error {
    Error::NoPath {
        x_m: start.x_m,
        y_m: start.y_m,
        heading_deg: start.heading_rad.to_degrees(),
        error_m: best.judgement.position_m,
        error_deg: best.judgement.heading_rad.to_degrees(),
        clearance_m: best.judgement.clearance_m,
        nearest,
    }
}

/// The narrowest aisle in which a start on the first line is planned; `None` if eight times the aisle does not suffice.
fn nearest_aisle_m(scene: &ParkingScene, start: ParkingStart, entry: &SlotEntry) -> Option<f64> {
    narrowest_m(scene.slot.aisle_m.max(0.1), &[2.0, 4.0, 8.0], |aisle_m| {
        let mut wider = scene.clone();
        wider.slot.aisle_m = aisle_m;
        attempt(&wider, start, entry).1
    })
}

/// The narrowest slot into which a start on the first line is planned; `None` if four times the width does not suffice.
fn nearest_slot_m(scene: &ParkingScene, start: ParkingStart) -> Option<f64> {
    narrowest_m(scene.slot.width_m, &[1.25, 1.5, 2.0, 4.0], |width_m| {
        let mut wider = scene.clone();
        wider.slot.width_m = width_m;
        entry_circle(&wider).is_ok_and(|entry| attempt(&wider, start, &entry).1)
    })
}

/// The smallest width from `low_m` up that fits, to a centimetre, if one of its multiples fits.
fn narrowest_m(low_m: f64, multiples: &[f64], fits: impl Fn(f64) -> bool) -> Option<f64> {
    let mut low = low_m;
    let mut high = multiples.iter().map(|f| f * low_m).find(|&width_m| fits(width_m))?;
    while high - low > 0.01 {
        let middle = 0.5 * (low + high);
        if fits(middle) {
            high = middle;
        } else {
            low = middle;
        }
    }
    Some(high)
}

/// The first plan that passes, otherwise the one with the most clearance of those that end nearest.
fn attempt(scene: &ParkingScene, start: ParkingStart, entry: &SlotEntry) -> (ParkingPlan, bool) {
    let tried = matches!(scene.method.straight_in, StraightIn::Tried(_));
    if let Some(plan) = direct(scene, start).filter(|p| tried && p.judgement.pass) {
        return (plan, true);
    }
    let mut best: Option<ParkingPlan> = None;
    for factor in RADII {
        for drive_up in [true, false] {
            let plan = by_circle(scene, start, &scene.circle(entry.radius_m * factor), drive_up);
            if plan.judgement.pass {
                return (plan, true);
            }
            if best.as_ref().is_none_or(|b| b.judgement.clearance_m < plan.judgement.clearance_m) {
                best = Some(plan);
            }
        }
    }
    (best.unwrap_or_else(|| by_circle(scene, start, entry, true)), false)
}

/// Straight in along the axis alone. Only from before the mouth with a heading within the method's angle of the axis, 80° by default: outward, or
/// inward for nose in.
fn direct(scene: &ParkingScene, start: ParkingStart) -> Option<ParkingPlan> {
    let turn = start.heading_rad - scene.goal().heading_rad;
    let (sin, cos) = scene.slot.angle_rad.sin_cos();
    let (most_rad, most_m) = match scene.method.straight_in {
        StraightIn::Tried(heading_rad) => (heading_rad, f64::INFINITY),
        StraightIn::Thresholds { heading_rad, offset_m } => (heading_rad, offset_m),
    };
    if start.y_m <= 0.0 || turn.cos() < most_rad.cos() || (start.y_m * cos - start.x_m * sin).abs() > most_m {
        return None;
    }
    let outward_m = start.x_m * cos + start.y_m * sin;
    let mut follower = follower(scene, start);
    let axis = axis_from(scene, outward_m.max(0.0) + scene.look_ahead.distance_m);
    enter(scene, &mut follower, &axis);
    let stages = vec![StageSpan { stage: ParkingStage::Enter, from: 0 }];
    Some(finish(scene, follower, stages, None))
}

/// By the first line and the circle. `drive_up`: first forward along the line; otherwise back along it at once.
fn by_circle(scene: &ParkingScene, start: ParkingStart, entry: &SlotEntry, drive_up: bool) -> ParkingPlan {
    if scene.nose_in {
        return nose_in(scene, start, entry, drive_up);
    }
    let mut follower = follower(scene, start);
    let mut stages = Vec::new();
    let (line_m, ahead_m) = (scene.line_m(), scene.look_ahead.distance_m);
    to_line(scene, &mut follower, &mut stages, entry.line_x_m, line_m, drive_up);
    let from_m = follower.last().x_m;
    let (back_m, end) = ((from_m - entry.line_x_m).max(0.0), PlanePoint::new(from_m.max(entry.line_x_m), line_m));
    let way = ReferenceLine::starting(end, PI)
        .then(back_m, 0.0)
        .then(entry.radius_m * scene.slot.angle_rad, 1.0 / entry.radius_m)
        .then(entry.axis_m - scene.parked_at_m(), 0.0);
    stages.push(StageSpan { stage: ParkingStage::Adjust, from: follower.path.poses.len() - 1 });
    let first = follower.path.poses.len() - 1;
    enter(scene, &mut follower, &way);
    let turning = follower.path.poses[first..].iter().position(|p| p.x_m <= entry.line_x_m + ahead_m).unwrap_or(0);
    stages.push(StageSpan { stage: ParkingStage::Enter, from: first + turning });
    finish(scene, follower, stages, Some(*entry))
}

/// Forward along the first line past the circle's start, until the vehicle is aligned with it; nothing without `drive_up`.
fn to_line(
    scene: &ParkingScene,
    follower: &mut LookAheadFollower,
    stages: &mut Vec<StageSpan>,
    circle_x_m: f64,
    line_m: f64,
    drive_up: bool,
) {
    if !drive_up {
        return;
    }
    let (start_m, ahead_m) = (follower.last().x_m, scene.look_ahead.distance_m);
    // from here the wheel still has enough distance to turn in
    let past_m = circle_x_m + 2.0 * ahead_m;
    let length = (past_m - start_m).max(0.0) + 1.0;
    let line = ReferenceLine::starting(PlanePoint::new(start_m, line_m), 0.0).then(length, 0.0);
    stages.push(StageSpan { stage: ParkingStage::Start, from: 0 });
    follower.follow(&line, Gear::Forward, length + 12.0 * ahead_m, |p, _| p.x_m >= past_m && on_line(p, line_m));
}

/// Nose in: back along the first line if the circle is already behind, forward along it, the circle and the axis. `drive_up`: before
/// backing up, forward along the line until the vehicle is aligned with it.
fn nose_in(scene: &ParkingScene, start: ParkingStart, entry: &SlotEntry, drive_up: bool) -> ParkingPlan {
    let mut follower = follower(scene, start);
    let mut stages = Vec::new();
    let (line_m, ahead_m) = (scene.line_m(), scene.look_ahead.distance_m);
    let before_m = entry.line_x_m - 2.0 * ahead_m;
    if start.x_m > before_m {
        let along = |p: &crate::guidance::PathPose| (p.y_m - line_m).abs() < 0.02 && p.heading_rad.sin().abs() < 0.02;
        if drive_up {
            let line = ReferenceLine::starting(PlanePoint::new(start.x_m, line_m), 0.0).then(12.0 * ahead_m, 0.0);
            stages.push(StageSpan { stage: ParkingStage::Start, from: 0 });
            follower.follow(&line, Gear::Forward, 12.0 * ahead_m, |p, _| along(p));
        }
        let from_m = follower.last().x_m;
        let length = from_m - before_m + 1.0;
        let back = ReferenceLine::starting(PlanePoint::new(from_m, line_m), PI).then(length, 0.0);
        stages.push(StageSpan { stage: ParkingStage::Adjust, from: follower.path.poses.len() - 1 });
        follower.follow(&back, Gear::Reverse, length + 12.0 * ahead_m, |p, _| p.x_m <= before_m && along(p));
    }
    let from = follower.path.poses.len() - 1;
    let from_m = follower.last().x_m;
    let way = ReferenceLine::starting(PlanePoint::new(from_m.min(entry.line_x_m), line_m), 0.0)
        .then((entry.line_x_m - from_m).max(0.0), 0.0)
        .then(entry.radius_m * (PI - scene.slot.angle_rad), -1.0 / entry.radius_m)
        .then(entry.axis_m - scene.parked_at_m(), 0.0);
    stages.push(StageSpan { stage: ParkingStage::Start, from });
    enter(scene, &mut follower, &way);
    let turning = follower.path.poses[from..].iter().position(|p| p.x_m >= entry.line_x_m - ahead_m).unwrap_or(0);
    stages.push(StageSpan { stage: ParkingStage::Enter, from: from + turning });
    finish(scene, follower, stages, Some(*entry))
}

/// Follows `way` to its end, within half a step.
fn enter(scene: &ParkingScene, follower: &mut LookAheadFollower, way: &ReferenceLine) {
    let end_m = way.length_m() - 0.5 * scene.look_ahead.step_m;
    let start_m = follower.last();
    let room = way.length_m() + 2.0 * start_m.x_m.hypot(start_m.y_m);
    follower.follow(way, scene.gear_in(), room, |_, s| s >= end_m);
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::parking::scene::usual_scene as scene;
    use crate::guidance::parking::success::{Success, success};
    use proptest::prelude::*;

    /// Starts on a grid beside the row, with a heading up to `askew_deg` off the row.
    fn grid(askew_deg: f64) -> Vec<ParkingStart> {
        let mut starts = Vec::new();
        for x in 0..5 {
            for y in 0..3 {
                for heading in -1..=1 {
                    let heading_rad = (f64::from(heading) * askew_deg).to_radians();
                    starts.push(ParkingStart {
                        x_m: -3.0 + 1.5 * f64::from(x),
                        y_m: 0.9 + 0.5 * f64::from(y),
                        heading_rad,
                        wheel_angle_rad: 0.0,
                    });
                }
            }
        }
        starts
    }

    #[test]
    fn from_a_grid_of_starts_it_parks_in_straight_and_slanted_slots() {
        for (angle_deg, obstacle_right) in [(90.0, true), (90.0, false), (60.0, true), (120.0, true), (45.0, true)] {
            let mut scene = scene(angle_deg);
            scene.slot.obstacle_right = obstacle_right;
            let found: Success = success(&scene, &grid(20.0));
            assert!(found.tried > 40, "{found:?}");
            // every usable start of this grid: a path that fails here is a defect of the planner, not of the scene
            assert_eq!(found.parked, found.tried, "{angle_deg}° {obstacle_right}: {found:?}");
        }
    }

    #[test]
    fn the_share_of_successes_falls_with_the_room() {
        let mut tight = scene(90.0);
        tight.slot.width_m = tight.least_width_m() + 0.02;
        tight.slot.aisle_m = 2.3;
        let found = success(&tight, &grid(60.0));
        let wide = success(&scene(90.0), &grid(60.0));
        assert!(found.share() < wide.share() && wide.share() > 0.6, "tight {found:?}, wide {wide:?}");
    }

    #[test]
    fn a_start_before_the_mouth_goes_straight_in() {
        let scene = scene(90.0);
        let start = ParkingStart { x_m: 0.05, y_m: 1.5, heading_rad: std::f64::consts::FRAC_PI_2 - 0.05, wheel_angle_rad: 0.0 };
        let plan = plan(&scene, start).unwrap();
        assert_eq!(plan.stages, [StageSpan { stage: ParkingStage::Enter, from: 0 }]);
        assert!(plan.entry.is_none() && plan.path.poses.iter().all(|p| p.direction == Gear::Reverse));
    }

    #[test]
    fn nose_in_it_parks_where_the_slot_lies_ahead_or_is_wide_and_says_from_which_width_on() {
        let mut lost = Vec::new();
        for (angle_deg, width_m) in [(120.0, 1.32), (135.0, 1.32), (105.0, 1.8), (90.0, 2.2)] {
            let mut scene = scene(angle_deg);
            (scene.nose_in, scene.slot.width_m) = (true, width_m);
            let found = success(&scene, &grid(20.0));
            if found.parked != found.tried {
                lost.push((angle_deg, found));
            }
            let plan = plan(&scene, ParkingStart { x_m: -3.0, y_m: 1.3, ..ParkingStart::default() }).unwrap();
            assert!(plan.path.poses.iter().all(|p| p.direction == Gear::Forward), "{:?}", plan.stages);
            let end = plan.path.poses[plan.path.poses.len() - 1];
            assert!(end.heading_rad.sin() * scene.slot.angle_rad.sin() < 0.0, "the nose points inward");
        }
        assert!(lost.is_empty(), "{lost:?}");
        let mut narrow = scene(90.0);
        narrow.nose_in = true;
        let start = ParkingStart { x_m: -3.0, y_m: narrow.line_m(), ..ParkingStart::default() };
        let error = plan(&narrow, start).unwrap_err();
        let Error::SlotTooNarrowToEnter { nearest_m, .. } = error else { panic!("{error}") };
        narrow.slot.width_m = nearest_m;
        assert!(plan(&narrow, start).is_ok(), "{nearest_m}");
    }

    #[test]
    fn a_start_that_looks_into_the_slot_goes_straight_in_nose_first() {
        let mut scene = scene(90.0);
        scene.nose_in = true;
        let start = ParkingStart { x_m: 0.05, y_m: 2.2, heading_rad: -std::f64::consts::FRAC_PI_2 + 0.05, wheel_angle_rad: 0.0 };
        let plan = plan(&scene, start).unwrap();
        assert_eq!(plan.stages, [StageSpan { stage: ParkingStage::Enter, from: 0 }]);
        assert!(plan.path.poses.iter().all(|p| p.direction == Gear::Forward));
    }

    #[test]
    fn an_infeasible_task_names_the_nearest_feasible_value() {
        let mut scene = scene(90.0);
        scene.slot.aisle_m = 1.45;
        let error = plan(&scene, ParkingStart { x_m: -2.0, y_m: 1.0, ..ParkingStart::default() }).unwrap_err();
        let Error::AisleTooNarrow { nearest_m, .. } = error else { panic!("{error}") };
        scene.slot.aisle_m = nearest_m;
        assert!(plan(&scene, ParkingStart { x_m: -2.0, y_m: scene.line_m(), ..ParkingStart::default() }).is_ok(), "{nearest_m}");
    }

    fn number() -> impl Strategy<Value = f64> {
        prop_oneof![4 => -5.0..5.0f64, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]
        #[test]
        fn no_start_panics_and_every_path_keeps_its_limits(x_m in number(), y_m in number(), heading_rad in number(), wheel_angle_rad in number()) {
            let scene = scene(75.0);
            if let Ok(plan) = plan(&scene, ParkingStart { x_m, y_m, heading_rad, wheel_angle_rad }) {
                let steps = crate::guidance::look_ahead::largest_steps(&plan.path);
                prop_assert!(steps.0 <= scene.look_ahead.wheel_step_rad + 1e-9);
                prop_assert!(plan.judgement.clearance_m >= scene.tolerance.clearance_m && plan.judgement.position_m <= 0.05);
                prop_assert!(plan.path.poses.windows(2).all(|p| (p[1].s_m - p[0].s_m - scene.look_ahead.step_m).abs() < 1e-9));
            }
        }

        #[test]
        fn no_slot_panics(width_m in number(), depth_m in number(), angle_rad in number(), aisle_m in number(), step_m in number()) {
            let mut scene = scene(90.0);
            (scene.slot.width_m, scene.slot.depth_m, scene.slot.angle_rad, scene.slot.aisle_m) = (width_m, depth_m, angle_rad, aisle_m);
            if step_m < 0.0 {
                scene.look_ahead.step_m = -step_m;
            }
            let _ = plan(&scene, ParkingStart { x_m: -2.0, y_m: 1.2, ..ParkingStart::default() });
        }
    }
}
