//! Parking where no single entry ends straight: enter as far as there is room, then shuffle on the axis. The plan with the fewest moves of those
//! from several first lines and entry circles.

use crate::guidance::parking::entry::SlotEntry;
use crate::guidance::parking::method::EntryMethod;
use crate::guidance::parking::parked_path::{ParkingPlan, finish, follower, on_line};
use crate::guidance::parking::scene::ParkingScene;
use crate::guidance::parking::shuffle::{MOST_MOVES, Room, shuffle};
use crate::guidance::parking::stage::{ParkingStage, StageSpan};
use crate::guidance::parking::start::ParkingStart;
use crate::guidance::reference::ReferenceLine;
use crate::guidance::{PathPose, PlanePoint};
use std::f64::consts::PI;

/// Moves forward along the first line when there is no room to align at once.
const LINE_MOVES: usize = 4;
/// A plan of so few moves is taken at once; one more is accepted after every so many further circles.
const FEW_MOVES: usize = 4;
const CIRCLES_PER_MOVE: usize = 3;

/// The plan with the fewest moves of those that enter as far as the room allows, and then shuffle. Only in reverse.
pub(crate) fn shuffled(scene: &ParkingScene, start: ParkingStart) -> Option<ParkingPlan> {
    if scene.nose_in {
        return None;
    }
    let mut best: Option<ParkingPlan> = None;
    for (k, (circle, line_m)) in tight_circles(scene).into_iter().enumerate() {
        for drive_up in [true, false] {
            let most = best.as_ref().map_or(MOST_MOVES, ParkingPlan::moves);
            let plan = in_moves(scene, start, &circle, (line_m, drive_up), most);
            if !plan.judgement.pass {
                continue;
            }
            let better = |b: &ParkingPlan| (plan.moves(), plan.path.poses.len()) < (b.moves(), b.path.poses.len());
            if best.as_ref().is_none_or(better) {
                best = Some(plan);
            }
        }
        if best.as_ref().is_some_and(|b| b.moves() <= FEW_MOVES + k / CIRCLES_PER_MOVE) {
            break;
        }
    }
    best
}

/// Entry circles for a first move that need not end on the axis: of the least radius, which begin where the body passes the obstacle's corner
/// with the safety distance or near that, from several first lines.
fn tight_circles(scene: &ParkingScene) -> Vec<(SlotEntry, f64)> {
    let half_m = 0.5 * scene.body.width_m;
    let (lowest_m, highest_m) = (half_m + scene.safety_m, scene.slot.aisle_m - half_m - scene.safety_m);
    let lines = [scene.line_m()].into_iter().chain((0..=4).map(|k| lowest_m + 0.25 * f64::from(k) * (highest_m - lowest_m)));
    let mut circles = Vec::new();
    for line_m in lines.filter(|&line_m| line_m >= lowest_m && line_m <= highest_m) {
        let circle = circle_past_corner(scene, line_m);
        if scene.method.entry == EntryMethod::SmallestRadius {
            return vec![(circle, line_m)];
        }
        circles.extend([0.0, -0.2, 0.2].map(|later_m| (SlotEntry { line_x_m: circle.line_x_m + later_m, ..circle }, line_m)));
    }
    circles
}

/// The circle of the least radius that touches a first line y = `line_m` and begins where the body passes the obstacle's corner with the safety
/// distance, but not beyond the circle that touches the axis.
pub(crate) fn circle_past_corner(scene: &ParkingScene, line_m: f64) -> SlotEntry {
    let radius_m = scene.least_radius_m();
    let tangent = scene.circle_at(radius_m, line_m);
    let (reach_m, corner) = (radius_m - 0.5 * scene.body.width_m - scene.safety_m, scene.corner());
    let down_m = line_m - radius_m - corner.y_m;
    let last_m = corner.x_m + (reach_m * reach_m - down_m * down_m).max(0.0).sqrt();
    SlotEntry { line_x_m: if scene.slot.obstacle_right { tangent.line_x_m.min(last_m) } else { tangent.line_x_m }, ..tangent }
}

/// Start and adjust on a first line y = `line_m`, the first move in along the circle as far as there is room, then at most `most` moves along
/// the axis.
fn in_moves(scene: &ParkingScene, start: ParkingStart, circle: &SlotEntry, (line_m, drive_up): (f64, bool), most: usize) -> ParkingPlan {
    let mut follower = follower(scene, start);
    let (mut stages, room, ahead_m) = (Vec::new(), Room::new(scene), scene.look_ahead.distance_m);
    if drive_up {
        let past_m = circle.line_x_m + 2.0 * ahead_m;
        stages.push(StageSpan { stage: ParkingStage::Start, from: 0 });
        let along = |p: &PathPose| on_line(p, line_m) && p.x_m >= past_m;
        for _ in 0..LINE_MOVES {
            let here_m = follower.last().x_m;
            let line = ReferenceLine::starting(PlanePoint::new(here_m, line_m), 0.0).then((past_m - here_m).max(0.0) + 12.0 * ahead_m, 0.0);
            let moved_m = room.follow(&mut follower, &line, scene.gear_out(), line.length_m(), along);
            if along(&follower.last()) || moved_m == 0.0 {
                break;
            }
            // no room to align: back by a length, along the same line
            let here_m = follower.last().x_m;
            let back = ReferenceLine::starting(PlanePoint::new(here_m, line_m), PI).then(scene.body.length_m(), 0.0);
            room.follow(&mut follower, &back, scene.gear_in(), back.length_m(), |_| false);
        }
    }
    let first = follower.path.poses.len() - 1;
    stages.push(StageSpan { stage: ParkingStage::Adjust, from: first });
    let from_m = follower.last().x_m;
    let way = ReferenceLine::starting(PlanePoint::new(from_m.max(circle.line_x_m), line_m), PI)
        .then((from_m - circle.line_x_m).max(0.0), 0.0)
        .then(circle.radius_m * scene.slot.angle_rad, 1.0 / circle.radius_m)
        .then(scene.slot.depth_m, 0.0);
    room.follow(&mut follower, &way, scene.gear_in(), way.length_m(), |_| false);
    let turning = follower.path.poses[first..].iter().position(|p| p.x_m <= circle.line_x_m + ahead_m).unwrap_or(0);
    stages.push(StageSpan { stage: ParkingStage::Enter, from: first + turning });
    shuffle(scene, &mut follower, &mut stages, most);
    finish(scene, follower, stages, Some(*circle))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::guidance::look_ahead::largest_steps;
    use crate::guidance::parking::plan;
    use crate::guidance::parking::scene::usual_scene;

    /// A slot 0.45 m wider than the vehicle, an aisle of 2 m for a vehicle of 1.4 m, and a wheel limit of 50°: least radius 0.9 m.
    fn tight_scene() -> ParkingScene {
        let mut scene = usual_scene(90.0);
        scene.slot.width_m = scene.body.width_m + 0.45;
        scene.slot.aisle_m = 2.0;
        scene.look_ahead.wheel_limit_rad = 50.0_f64.to_radians();
        scene
    }

    /// 241 starts beside the row, up to 20° askew; those nearer than 0.1 m to an obstacle are left out.
    fn askew_starts(scene: &ParkingScene) -> Vec<ParkingStart> {
        let room = Room::new(scene);
        let mut starts = Vec::new();
        for x in 0..6 {
            for y in 0..6 {
                for heading_deg in [-20.0, -12.0, -6.0, 0.0, 6.0, 12.0, 20.0_f64] {
                    let (x_m, y_m) = (-3.0 + 0.8 * f64::from(x), 0.75 + 0.1 * f64::from(y));
                    let start = ParkingStart { x_m, y_m, heading_rad: heading_deg.to_radians(), wheel_angle_rad: 0.0 };
                    let pose = follower(scene, start).last();
                    if room.clearance_m(&pose) >= scene.tolerance.clearance_m {
                        starts.push(start);
                    }
                }
            }
        }
        starts
    }

    #[test]
    fn from_two_hundred_starts_in_a_narrow_aisle_it_parks_with_as_many_moves_as_it_takes() {
        use rayon::prelude::*;
        let scene = tight_scene();
        let starts = askew_starts(&scene);
        let plans: Vec<_> = starts.par_iter().map(|start| plan(&scene, *start)).collect();
        let parked: Vec<_> = plans.iter().flatten().collect();
        let shuffled: Vec<_> = parked.iter().filter(|plan| plan.shuffles() > 0).collect();
        let moves = shuffled.iter().map(|plan| plan.moves());
        let found = format!(
            "{} starts, {} parked, {} of them with shuffling in {} to {} moves, {:.1} in the mean",
            starts.len(),
            parked.len(),
            shuffled.len(),
            moves.clone().min().unwrap_or(0),
            moves.clone().max().unwrap_or(0),
            moves.clone().sum::<usize>() as f64 / shuffled.len().max(1) as f64
        );
        assert!(shuffled.len() >= 200 && parked.len() == starts.len(), "{found}");
        let (wheel_rad, curvature) = (scene.look_ahead.wheel_step_rad, scene.look_ahead.curvature_step_per_m(scene.body.wheelbase_m));
        for plan in parked {
            let steps = largest_steps(&plan.path);
            assert!(plan.judgement.clearance_m >= scene.tolerance.clearance_m - 1e-9, "{:?}", plan.judgement);
            assert!(steps.0 <= wheel_rad + 1e-9 && steps.1 <= curvature + 1e-9, "{steps:?}");
            // every move along the axis is a stage, and each changes the direction
            for pair in plan.stages.windows(2).filter(|pair| pair[1].stage == ParkingStage::Shuffle) {
                let (before, after) = (plan.path.poses[pair[1].from - 1].direction, plan.path.poses[pair[1].from].direction);
                assert!(before != after, "{:?}", plan.stages);
            }
        }
    }

    #[test]
    fn a_circle_too_large_for_the_slot_is_entered_in_moves() {
        let mut scene = tight_scene();
        (scene.look_ahead.wheel_limit_rad, scene.slot.aisle_m) = (28.0_f64.to_radians(), 3.2);
        assert!(crate::guidance::parking::entry::entry_circle(&scene).is_err(), "no circle passes the corner");
        let start = ParkingStart { x_m: -2.0, y_m: 1.5, heading_rad: 0.1, wheel_angle_rad: 0.0 };
        let plan = plan(&scene, start).unwrap();
        assert!(plan.judgement.pass && plan.shuffles() > 1, "{} moves, {:?}", plan.moves(), plan.judgement);
    }

    #[test]
    fn askew_in_the_slot_it_straightens_along_the_axis() {
        let mut scene = usual_scene(90.0);
        scene.slot.width_m += 0.5;
        let start = ParkingStart { x_m: 0.15, y_m: -0.45, heading_rad: std::f64::consts::FRAC_PI_2 - 0.12, wheel_angle_rad: 0.0 };
        let (mut follower, mut stages) = (follower(&scene, start), vec![StageSpan { stage: ParkingStage::Enter, from: 0 }]);
        shuffle(&scene, &mut follower, &mut stages, MOST_MOVES);
        let plan = finish(&scene, follower, stages, None);
        assert!(plan.judgement.pass && plan.shuffles() > 0, "{:?} {:?}", plan.judgement, plan.stages);
    }
}
