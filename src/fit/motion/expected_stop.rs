//! Where a segment that comes to rest ends.
//!
//! A wheel at rest reads as motion without acceleration, so the readings after the stop must not count. The readings show the stop late, at
//! a random time, and a segment that they end keeps some of that error. So it ends where the stop is expected from the surface and the
//! readings so far, as the next reading is predicted: a rule that does not look ahead leaves the innovations unbiased. (With 18 mm/s of
//! noise an end by the readings left 0.6 to 1 N·m of error at the last 0.05 m/s.)

use crate::fit::motion::integration::Course;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::passes::{along_one, wide_speed};
use crate::fit::noise::model::Noise;
use crate::fit::surface::lattice::LatticeSurface;

/// A stop is near when the expected speed is at most this many standard deviations above 0.
const STANDARD_DEVIATIONS: f64 = 3.0;
/// And this, for the error of the surface [m/s].
const MARGIN_MPS: f64 = 2e-3;
/// Look-ups along the segment: the second uses the filtered speeds of the first.
const LOOKS: usize = 2;

/// Number of readings of a segment before its stop; the first `least` are not examined. `None` if no stop is expected.
pub(crate) fn readings_before_stop(course: &Course, surface: &LatticeSurface, noise: &Noise, least: usize) -> Option<usize> {
    let mut speeds = Speeds::from(wide_speed(course.segment));
    let mut expected_std_mps = Vec::new();
    for _ in 0..LOOKS {
        let found = along_one(course, surface, noise, &speeds);
        (speeds, expected_std_mps) = (found.speeds, found.expected_std_mps);
    }
    let stops = |&row: &usize| {
        let torque_nm = course.steps(row).last().map_or(0.0, |s| s.torque.torque_nm);
        let speed_mps = speeds.before[row];
        speed_mps < STANDARD_DEVIATIONS * expected_std_mps[row] + MARGIN_MPS && surface.accel_mps2(speed_mps, torque_nm) < 0.0
    };
    (least.min(course.rows())..course.rows()).find(stops)
}
