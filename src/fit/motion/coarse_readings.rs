//! Readings in coarse steps, treated as intervals, segment by segment.

use crate::fit::calibration::Calibration;
use crate::fit::drive::effective_torque::EffectiveTorque;
use crate::fit::motion::integration::{Course, surface_of};
use crate::fit::motion::log_data::LogData;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::passes::{along_one, wide_speed};
use crate::fit::motion::segment::Segment;
use crate::fit::motion::so_far::SoFar;
use crate::fit::noise::quantisation;
use rayon::prelude::*;

/// Rounds between the speeds of a segment and the intervals of its readings.
const ROUNDS: usize = 3;

/// Replaces the readings of every segment whose log has a speed in coarse steps, by the surface as it is.
pub(crate) fn replace_coarse(
    segments: &mut [Segment],
    logs: &[LogData],
    calibration: &Calibration,
    torques: &[EffectiveTorque],
    so_far: SoFar,
) {
    segments.par_iter_mut().for_each(|segment| {
        let log = segment.log;
        replace_coarse_of(segment, &logs[log], calibration.encoder_scale, (&torques[log], calibration.dead_time_s[log]), so_far);
    });
}

/// The same for one segment of a log, with its torque and dead time [s].
pub(crate) fn replace_coarse_of(
    segment: &mut Segment,
    log: &LogData,
    encoder_scale: f64,
    (torque, dead_time_s): (&EffectiveTorque, f64),
    SoFar { surfaces, noise }: SoFar,
) {
    if log.coarse_mps == [0.0; 2] || segment.readings.is_empty() {
        return;
    }
    let surface = surface_of(surfaces, segment);
    let plain = segment.clone();
    let course = Course::new(&plain, torque, dead_time_s);
    let [encoder_mps, yaw_mps] = log.coarse_mps;
    let steps_mps = [encoder_mps / encoder_scale, yaw_mps];
    let start = (segment.start_s, segment.start_std(noise));
    let mut speeds: Speeds = wide_speed(&plain).into();
    // the speeds at which the surface is looked up follow the readings, and these the speeds
    for _ in 0..ROUNDS {
        segment.readings.clone_from(&plain.readings);
        quantisation::replace_coarse(&mut segment.readings, &course.predicted(&speeds, surface), steps_mps, start, noise);
        speeds = along_one(&Course::new(segment, torque, dead_time_s), surface, noise, &speeds).speeds;
    }
}
