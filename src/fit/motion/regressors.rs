//! The regressors of one segment: integrals of the surface's columns along it, never derivatives.
//!
//! Φ_k(t) = ∫ B_k(V̂(s), u(s)) ds from the segment's start ([`Course`]). Further columns give the effect of the delays and of the encoder's
//! calibration: ∫ A_U·∂u/∂T_d ds, ∫ A_U·∂u/∂T_c ds, V̂ and −dV̂/dt at the encoder's readings.

use crate::fit::motion::integration::Course;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::noise::model::Noise;
use crate::fit::noise::whitening::{Filter, States};
use crate::fit::nuisance;
use crate::fit::solve::normal_equations::LocalGram;
use crate::fit::surface::lattice::{LatticeSurface, Spot};

/// Unknowns besides the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Free {
    /// The surface alone.
    Surface,
    /// Dead times and drive too.
    Delays,
    /// What changes during the campaign as well.
    DelaysAndDrift,
    /// The encoder's scale and delay as well. Readings must not be merged then: the difference between two speed sources at one moment
    /// calibrates the encoder.
    DelaysAndEncoder,
}

impl Free {
    /// Nuisance columns besides the surface's for this many logs.
    pub(crate) fn nuisances(self, logs: usize) -> usize {
        if self == Self::Surface { 0 } else { nuisance::DEAD_TIME + logs }
    }
}

/// Rows that are whitened and added up at once: few enough to stay in the nearest cache.
const PANEL_ROWS: usize = 32;

/// The sums over the whitened rows of one segment. The surface gives the slopes of the nuisance columns, if any are free.
///
/// A column of the surface is zero until the segment reaches it. So the columns are ordered by the first panel of rows that touches them,
/// and each panel is only as wide as the columns touched up to its end.
pub(crate) fn whitened_sums(course: &Course, speeds: &Speeds, surface: &LatticeSurface, noise: &Noise, free: Free) -> LocalGram {
    let with_nuisance = free != Free::Surface;
    let segment = course.segment;
    let lattice = &surface.lattice;
    let base = lattice.columns();
    // the speed, then the nuisance columns
    let mut columns: Vec<u32> = vec![u32::MAX];
    if with_nuisance {
        columns.extend((0..nuisance::DEAD_TIME).map(|c| (base + c) as u32));
        columns.push((base + nuisance::DEAD_TIME + segment.log) as u32);
    }
    // the columns that each step of the integration touches
    let mut places = vec![u32::MAX; base];
    let mut widths: Vec<usize> = Vec::with_capacity(course.rows().div_ceil(PANEL_ROWS));
    let mut spots: Vec<Spot> = Vec::with_capacity(2 * course.rows());
    for from in (0..course.rows()).step_by(PANEL_ROWS) {
        let before = columns.len();
        for row in from..(from + PANEL_ROWS).min(course.rows()) {
            for (v, step) in course.along(speeds, row) {
                let spot = lattice.spot(v, step.torque.torque_nm);
                for i in 0..4 {
                    let first = lattice.column(spot.along_speed.first + i, spot.along_torque.first);
                    for (column, place) in (first..).zip(&mut places[first..first + 4]) {
                        if *place == u32::MAX {
                            *place = 0;
                            columns.push(column as u32);
                        }
                    }
                }
                spots.push(spot);
            }
        }
        columns[before..].sort_unstable();
        for (place, column) in (before..).zip(&columns[before..]) {
            places[*column as usize] = place as u32;
        }
        widths.push(columns.len());
    }
    let filter = Filter::over(&segment.readings, segment.start_s, noise, segment.start_std(noise));
    let mut states = States::new(columns.len());
    let mut sums = vec![0.0; columns.len()];
    let mut panel: Vec<f64> = Vec::with_capacity(PANEL_ROWS * columns.len());
    let mut gram = LocalGram::new(columns);
    let mut drifted_mps = 0.0;
    let friction_share = course.friction_share();
    let mut spots = spots.iter();
    for (from, width) in (0..course.rows()).step_by(PANEL_ROWS).zip(widths) {
        panel.clear();
        for row in from..(from + PANEL_ROWS).min(course.rows()) {
            for ((v, step), spot) in course.along(speeds, row).zip(&mut spots) {
                for i in 0..4 {
                    let first = lattice.column(spot.along_speed.first + i, spot.along_torque.first);
                    let by_speed = step.length_s * spot.along_speed.value[i];
                    for (place, by_torque) in places[first..first + 4].iter().zip(spot.along_torque.value) {
                        sums[*place as usize] += by_speed * by_torque;
                    }
                }
                if friction_share != 0.0 || free == Free::DelaysAndDrift {
                    let friction_mps = step.length_s * surface.accel_mps2(v, 0.0);
                    drifted_mps += friction_share * friction_mps;
                    for (k, progress) in segment.progress.iter().enumerate() {
                        sums[1 + nuisance::DRIFT_FRICTION + k] += friction_mps * progress;
                    }
                }
                // a constant torque has no delay
                if with_nuisance && (free == Free::DelaysAndDrift || step.torque.is_moving()) {
                    let slope = step.length_s * surface.value_and_slope(v, step.torque.torque_nm).1;
                    if free == Free::DelaysAndDrift {
                        for (k, progress) in segment.progress.iter().enumerate() {
                            sums[1 + nuisance::DRIFT_TORQUE + k] += slope * step.torque.torque_nm * progress;
                        }
                    }
                    for (sum, by) in sums[1 + nuisance::DRIVE..].iter_mut().zip(step.torque.by_drive) {
                        *sum += slope * by;
                    }
                    sums[1 + nuisance::DEAD_TIME] += slope * step.torque.by_dead_time;
                }
            }
            let reading = segment.readings[row];
            sums[0] = reading.speed_mps - drifted_mps;
            if free == Free::DelaysAndEncoder {
                let [scale, delay] = if reading.source == 0 {
                    let v = speeds.before[row].max(0.0);
                    let torque_nm = course.steps(row).last().map_or(0.0, |s| s.torque.torque_nm);
                    [v, -surface.accel_mps2(v, torque_nm)]
                } else {
                    [0.0, 0.0]
                };
                sums[1 + nuisance::ENCODER_SCALE] = scale;
                sums[1 + nuisance::ENCODER_DELAY] = delay;
            }
            panel.extend_from_slice(&sums[..width]);
        }
        filter.whiten_from(from, &mut panel, width, &mut states);
        gram.add(&panel, width);
    }
    gram
}

/// The score Xᵀe of one segment, e its whitened `residual` and X the whitened columns of surface and delays, added to `score` over the
/// columns that are free; the encoder's stay as they are. X is not formed: transposed whitening turns e into a weight per step.
pub(crate) fn add_score(course: &Course, speeds: &Speeds, surface: &LatticeSurface, noise: &Noise, free: Free, score: &mut [f64]) {
    let segment = course.segment;
    let lattice = &surface.lattice;
    let base = lattice.columns();
    let predicted = course.predicted(speeds, surface);
    let mut white: Vec<f64> = segment.readings.iter().zip(predicted).map(|(r, p)| r.speed_mps - p).collect();
    let filter = Filter::over(&segment.readings, segment.start_s, noise, segment.start_std(noise));
    filter.whiten(&mut white, 1);
    let mut counts = filter.whiten_transposed(&white);
    // a step counts in every reading that follows
    for row in (1..counts.len()).rev() {
        counts[row - 1] += counts[row];
    }
    for (row, count) in counts.iter().enumerate() {
        for (v, step) in course.along(speeds, row) {
            let weight = step.length_s * count;
            for (column, share) in lattice.spot(v, step.torque.torque_nm).columns(lattice) {
                score[column] += weight * share;
            }
            if free == Free::DelaysAndDrift {
                let friction = weight * surface.accel_mps2(v, 0.0);
                for (k, progress) in segment.progress.iter().enumerate() {
                    score[base + nuisance::DRIFT_FRICTION + k] += friction * progress;
                }
            }
            if free == Free::DelaysAndDrift || step.torque.is_moving() {
                let slope = weight * surface.value_and_slope(v, step.torque.torque_nm).1;
                if free == Free::DelaysAndDrift {
                    for (k, progress) in segment.progress.iter().enumerate() {
                        score[base + nuisance::DRIFT_TORQUE + k] += slope * step.torque.torque_nm * progress;
                    }
                }
                for (score, by) in score[base + nuisance::DRIVE..].iter_mut().zip(step.torque.by_drive) {
                    *score += slope * by;
                }
                score[base + nuisance::DEAD_TIME + segment.log] += slope * step.torque.by_dead_time;
            }
        }
    }
}
