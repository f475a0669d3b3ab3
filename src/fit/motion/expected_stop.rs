//! Where a segment ends that comes to rest.
//!
//! A wheel that stands reads as motion without acceleration, so what follows the stop must not count. When it stands the readings tell late
//! and by chance, and a segment that ends where they happen to fall keeps some of that chance. So it ends where the stop is expected from the
//! readings so far and the surface, which is no more than what the next reading is predicted from: a rule that does not look ahead leaves
//! innovations that mean nothing. (With 18 mm/s of noise an end by the readings left 0.6 to 1 N·m of error at the last 0.05 m/s.)

use crate::fit::motion::integration::Course;
use crate::fit::motion::lookup_speeds::Speeds;
use crate::fit::motion::passes::{along_one, wide_speed};
use crate::fit::noise::model::Noise;
use crate::fit::surface::lattice::LatticeSurface;

/// A stop is near when no more than this many standard deviations of the expected speed are left.
const STANDARD_DEVIATIONS: f64 = 3.0;
/// And this, for what the surface does not know [m/s].
const MARGIN_MPS: f64 = 2e-3;
/// Looks along the segment: the second goes by the speeds that the first has filtered.
const LOOKS: usize = 2;

/// How many readings of a segment come before its stop, of which the first `least` are not asked; `None` where no stop is expected.
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
