//! `manoeuvre_traces.json`: the path, the nominal run and the judged errors of every manoeuvre. For display only; the verdict does not
//! depend on it.
//!
//! It belongs to a Table 2, not to one `verify.json`: a later verdict on the pivots alone does not change it.

use crate::control::Pose;
use crate::guidance::Polygon;
use crate::guidance::path::PosePath;
use crate::guidance::route::follower::DriveStage;
use crate::guidance::route::path_position::{Leg, lateral_error_m};
use crate::manoeuvre::drive::ManoeuvreMoment;
use crate::manoeuvre::planned_task::Planned;
use crate::manoeuvre::scenario::{Manoeuvre, ManoeuvreKind};
use crate::map::{FORMAT_VERSION, Gear, parse_file};
use crate::units::RAD_PER_DEG;
use crate::verify::{Maps, Result, ScenarioVerdict};
use serde::{Deserialize, Serialize};

/// Value of the `format` field.
const FORMAT: &str = "pivot-cal/manoeuvre_traces";

/// `manoeuvre_traces.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ManoeuvreTraces {
    /// Always `pivot-cal/manoeuvre_traces`.
    pub format: String,
    /// Version of this layout.
    pub format_version: u32,
    /// Version of the program that wrote it.
    pub tool_version: String,
    /// Identifier of the generation, that of the Table 1 behind the file; empty in files of versions before it.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub generation: String,
    /// SHA-256 of the Table 2 files that were judged, forward first.
    pub table2_csv_sha256: Vec<String>,
    /// Perturbed plants per manoeuvre.
    pub draws: usize,
    /// The manoeuvres that were tested.
    pub manoeuvres: Vec<ManoeuvreTrace>,
}

/// One manoeuvre.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ManoeuvreTrace {
    /// Its verdict.
    pub verdict: ScenarioVerdict,
    /// The path of the rear axle's middle, a piece per direction of travel.
    pub planned: Vec<TracePiece>,
    /// True places of the rear axle's middle in the nominal run [m].
    pub driven_m: Vec<[f64; 2]>,
    /// Outlines of the vehicle along the planned path [m], the last one at its end; none without obstacles.
    pub outlines: Vec<TracePiece>,
    /// Corners of the field [m], if it has one.
    pub field_m: Vec<[f64; 2]>,
    /// Corners of each obstacle [m].
    pub obstacles_m: Vec<Vec<[f64; 2]>>,
    /// Lateral error over time or distance, a line per piece of the run, for manoeuvres that are judged by it.
    pub errors: Vec<ErrorTrace>,
}

/// Points with a direction of travel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TracePiece {
    /// Direction of travel.
    pub gear: Gear,
    /// Points [m].
    pub points_m: Vec<[f64; 2]>,
}

/// Lateral error along a piece of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ErrorTrace {
    /// Whether the lateral compensation was in use.
    pub compensated: bool,
    /// Time since the start [s].
    pub t_s: Vec<f64>,
    /// Place on the path [m].
    pub way_m: Vec<f64>,
    /// Lateral error [m], left of the vehicle positive: true in compensation runs, the controller's elsewhere; means of 0.1 s.
    pub error_m: Vec<f64>,
    /// Compensation in force [°].
    pub compensation_deg: Vec<f64>,
}

impl ManoeuvreTraces {
    /// The traces of the tested manoeuvres.
    pub(crate) fn new(maps: &Maps, draws: usize, manoeuvres: Vec<ManoeuvreTrace>) -> Self {
        Self {
            format: FORMAT.to_owned(),
            format_version: FORMAT_VERSION,
            tool_version: env!("CARGO_PKG_VERSION").to_owned(),
            generation: maps.table1.generation.clone(),
            table2_csv_sha256: maps.csv_sha256.clone(),
            draws,
            manoeuvres,
        }
    }

    /// As JSON.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub(crate) fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string(self)? + "\n")
    }

    /// Reads the JSON of [`ManoeuvreTraces::to_json`].
    ///
    /// # Errors
    /// JSON that is not of this format and version.
    pub(crate) fn from_json(text: &str) -> Result<Self> {
        Ok(parse_file(text, FORMAT)?)
    }
}

/// Outlines shown along a path.
const OUTLINES: usize = 14;
/// Points of a driven path are this far apart, or more [m].
const APART_M: f64 = 0.03;
/// Control periods that are averaged: a tenth of a second.
const PERIODS: usize = 5;

/// A nominal run.
pub(crate) struct NominalRun<'a> {
    /// The path to be driven.
    pub(crate) path: &'a PosePath,
    /// Its plan, if it was planned beforehand.
    pub(crate) planned: Option<&'a Planned>,
    /// The drive without compensation, if there are two.
    pub(crate) uncompensated: &'a [ManoeuvreMoment],
    /// The drive.
    pub(crate) moments: &'a [ManoeuvreMoment],
}

impl ManoeuvreTrace {
    /// The trace of a manoeuvre's nominal run.
    pub(crate) fn new(manoeuvre: &Manoeuvre, verdict: ScenarioVerdict, run: &NominalRun<'_>) -> Self {
        let mut found = Self {
            verdict,
            planned: pieces(run.path),
            driven_m: driven(run.moments),
            outlines: Vec::new(),
            field_m: Vec::new(),
            obstacles_m: Vec::new(),
            errors: Vec::new(),
        };
        if let Some(planned) = run.planned {
            let poses = &run.path.poses;
            found.field_m = planned.field.as_ref().map(corners).unwrap_or_default();
            found.obstacles_m = planned.obstacles.iter().map(corners).collect();
            let every = (poses.len() / OUTLINES).max(1);
            let shown = poses.iter().step_by(every).chain(poses.last());
            found.outlines = shown.map(|p| TracePiece { gear: p.direction, points_m: corners(&planned.body.at_pose(p)) }).collect();
        }
        found.errors = match &manoeuvre.kind {
            ManoeuvreKind::Planned(_) => Vec::new(),
            ManoeuvreKind::Polyline { .. } => seen_errors(run.moments),
            ManoeuvreKind::Compensation(_) => {
                vec![true_errors(run.path, run.uncompensated, false), true_errors(run.path, run.moments, true)]
            }
        };
        found
    }
}

/// Rounds to a tenth of a millimetre and of a millidegree.
fn short(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

fn corners(polygon: &Polygon) -> Vec<[f64; 2]> {
    polygon.corners().iter().map(|c| [short(c.x_m), short(c.y_m)]).collect()
}

/// The path by direction of travel, without needless points on straights.
fn pieces(path: &PosePath) -> Vec<TracePiece> {
    let poses = &path.poses;
    let mut pieces: Vec<TracePiece> = Vec::new();
    for (k, pose) in poses.iter().enumerate() {
        let point = [short(pose.x_m), short(pose.y_m)];
        if let Some(piece) = pieces.last_mut().filter(|p| p.gear == pose.direction) {
            piece.points_m.push(point);
        } else {
            // the new piece begins where the last one ends
            let before = k.checked_sub(1).map(|b| [short(poses[b].x_m), short(poses[b].y_m)]);
            pieces.push(TracePiece { gear: pose.direction, points_m: before.into_iter().chain([point]).collect() });
        }
    }
    pieces.into_iter().map(|p| TracePiece { gear: p.gear, points_m: thinned(&p.points_m) }).collect()
}

fn driven(moments: &[ManoeuvreMoment]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    for (k, moment) in moments.iter().enumerate() {
        let point = [short(moment.state.x_m), short(moment.state.y_m)];
        if k + 1 == moments.len() || kept.last().is_none_or(|last| (point[0] - last[0]).hypot(point[1] - last[1]) >= APART_M) {
            kept.push(point);
        }
    }
    thinned(&kept)
}

/// Removes points that lie within half a millimetre of the line between the kept ones. Source: Douglas & Peucker (1973).
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const WITHIN_M: f64 = 5e-4;
    if points.len() < 3 {
        return points.to_vec();
    }
    let mut keep = vec![false; points.len()];
    (keep[0], keep[points.len() - 1]) = (true, true);
    let mut open = vec![(0, points.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let (a, b) = (points[from], points[to]);
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = dx.hypot(dy);
        let off = |p: [f64; 2]| {
            let (x, y) = (p[0] - a[0], p[1] - a[1]);
            if length > 1e-9 { (dx * y - dy * x).abs() / length } else { x.hypot(y) }
        };
        let furthest = (from + 1..to).map(|k| (off(points[k]), k)).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, k)) = furthest.filter(|f| f.0 > WITHIN_M) {
            keep[k] = true;
            open.extend([(from, k), (k, to)]);
        }
    }
    points.iter().zip(keep).filter_map(|(point, keep)| keep.then_some(*point)).collect()
}

/// The controller's error while driving, a trace per leg.
fn seen_errors(moments: &[ManoeuvreMoment]) -> Vec<ErrorTrace> {
    let driving: Vec<&ManoeuvreMoment> =
        moments.iter().filter(|m| m.command.stage == DriveStage::Driving && m.command.matched.is_some()).collect();
    let mut traces: Vec<(usize, ErrorTrace)> = Vec::new();
    for chunk in driving.chunks(PERIODS).filter(|c| c.iter().all(|m| m.leg == c[0].leg)) {
        if traces.last().is_none_or(|t| t.0 != chunk[0].leg) {
            traces.push((chunk[0].leg, ErrorTrace::new(false)));
        }
        let mean = |of: &dyn Fn(&ManoeuvreMoment) -> f64| chunk.iter().map(|m| of(m)).sum::<f64>() / chunk.len() as f64;
        if let Some((_, trace)) = traces.last_mut() {
            let way_m = chunk[0].command.matched.map_or(0.0, |m| m.s_m);
            trace.push(chunk[0].state.t_s, way_m, mean(&|m| m.command.lateral_error_m), mean(&|m| m.compensation_rad));
        }
    }
    traces.into_iter().map(|t| t.1).collect()
}

/// The true error on a path of one leg.
fn true_errors(path: &PosePath, moments: &[ManoeuvreMoment], compensated: bool) -> ErrorTrace {
    let mut trace = ErrorTrace::new(compensated);
    let Some(leg) = Leg::first(&path.poses) else { return trace };
    let mut index = 0;
    // time, distance, error, compensation
    let places: Vec<[f64; 4]> = moments
        .iter()
        .map(|m| {
            let pose = Pose { x_m: m.state.x_m, y_m: m.state.y_m, heading_rad: m.state.heading_rad };
            let (matched, found) = leg.nearest(pose.x_m, pose.y_m, index);
            index = found;
            [m.state.t_s, matched.s_m, lateral_error_m(pose, matched.x_m, matched.y_m), m.compensation_rad]
        })
        .collect();
    for chunk in places.chunks(2 * PERIODS) {
        let mean = |of: fn(&[f64; 4]) -> f64| chunk.iter().map(of).sum::<f64>() / chunk.len() as f64;
        trace.push(chunk[0][0], mean(|p| p[1]), mean(|p| p[2]), mean(|p| p[3]));
    }
    trace
}

impl ErrorTrace {
    fn new(compensated: bool) -> Self {
        Self { compensated, t_s: Vec::new(), way_m: Vec::new(), error_m: Vec::new(), compensation_deg: Vec::new() }
    }

    fn push(&mut self, t_s: f64, way_m: f64, error_m: f64, compensation_rad: f64) {
        self.t_s.push(short(t_s));
        self.way_m.push(short(way_m));
        self.error_m.push((error_m * 1e6).round() / 1e6);
        self.compensation_deg.push(short(compensation_rad / RAD_PER_DEG));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_corners_and_stays_within_half_a_millimetre() {
        let arc: Vec<[f64; 2]> = (0..=400).map(|k| (0.01 * f64::from(k)).sin_cos()).map(|(s, c)| [c, s]).collect();
        let kept = thinned(&arc);
        assert!(kept.len() < 90 && kept.len() > 30, "{}", kept.len());
        for pair in kept.windows(2) {
            let middle = [0.5 * (pair[0][0] + pair[1][0]), 0.5 * (pair[0][1] + pair[1][1])];
            assert!(1.0 - middle[0].hypot(middle[1]) < 6e-4);
        }
        let corner = [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0]];
        assert_eq!(thinned(&corner), [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    }
}
