//! The lateral error and the heading rate on a stretch of a path, and their comparison between two drives.

use crate::control::Pose;
use crate::guidance::path::PosePath;
use crate::guidance::route::path_position::{Leg, lateral_error_m};
use crate::manoeuvre::drive::ManoeuvreDriver;
use crate::verify::drive::{Observer, Period};
use crate::verify::{Metric, Values};
use std::ops::Range;

/// Sums of one drive.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LateralFigures {
    /// Integral of the lateral error over the distance [m²], and the distance [m].
    error_m2: f64,
    way_m: f64,
    /// Σ θ̇² and their number over the whole stretch, and over its straights alone.
    rates: [(f64, f64); 2],
}

/// Observes a drive along a path of one leg.
pub(crate) struct LateralMetrics<'a> {
    leg: Option<Leg<'a>>,
    /// The stretch [m].
    measured_m: Range<f64>,
    wheelbase_m: f64,
    index: usize,
    last_m: f64,
    pub(crate) figures: LateralFigures,
}

impl<'a> LateralMetrics<'a> {
    pub(crate) fn new(path: &'a PosePath, measured_m: Range<f64>, wheelbase_m: f64) -> Self {
        let leg = Leg::first(&path.poses);
        Self { leg, measured_m, wheelbase_m, index: 0, last_m: 0.0, figures: LateralFigures::default() }
    }
}

impl<'b> Observer<ManoeuvreDriver<'b>> for LateralMetrics<'_> {
    fn see(&mut self, period: &Period<'_, ManoeuvreDriver<'b>>) {
        let Some(leg) = self.leg else { return };
        let state = period.moment.state;
        let (matched, found) = leg.nearest(state.x_m, state.y_m, self.index);
        self.index = found;
        let way_m = (matched.s_m - self.last_m).max(0.0);
        self.last_m = matched.s_m;
        if self.measured_m.contains(&matched.s_m) {
            let pose = Pose { x_m: state.x_m, y_m: state.y_m, heading_rad: state.heading_rad };
            let error_m = lateral_error_m(pose, matched.x_m, matched.y_m);
            let rate_rad_s = state.speed_mps * state.wheel_angle_rad.sin() / self.wheelbase_m;
            self.figures.error_m2 += way_m * error_m;
            self.figures.way_m += way_m;
            let straight = matched.curvature_per_m == 0.0;
            for (squares, count) in &mut self.figures.rates[..if straight { 2 } else { 1 }] {
                *squares += rate_rad_s * rate_rad_s;
                *count += 1.0;
            }
        }
    }
}

/// The metrics of a drive without compensation and one with it; `ended`: whether both reached the end of the path.
pub(crate) fn compared(before: &LateralFigures, after: &LateralFigures, ended: bool) -> Values {
    let mut values = Values::default();
    values.set(Metric::AsExpected, f64::from(u8::from(ended)));
    let mean_m = |f: &LateralFigures| (f.error_m2 / f.way_m).abs();
    let (before_m, after_m) = (mean_m(before), mean_m(after));
    values.set(Metric::LateralBeforeM, before_m);
    values.set(Metric::LateralAfterM, after_m);
    values.set(Metric::LateralRatio, after_m / before_m);
    // on the straights nothing hides an oscillation: the larger ratio counts
    let ratio = |k: usize| {
        let rms = |f: &LateralFigures| (f.rates[k].0 / f.rates[k].1).sqrt();
        rms(after) / rms(before)
    };
    values.set(Metric::HeadingRateRatio, ratio(0).max(ratio(1)));
    values
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_oscillation_on_the_straights_counts_although_the_bend_hides_it() {
        let figures =
            |error_m2: f64, straight: f64| LateralFigures { error_m2, way_m: 10.0, rates: [(100.0 + straight, 50.0), (straight, 25.0)] };
        let values = compared(&figures(-0.4, 1.0), &figures(0.1, 4.0), true);
        let get = |m| values.get(m).unwrap();
        assert!((get(Metric::LateralBeforeM) - 0.04).abs() < 1e-12 && (get(Metric::LateralRatio) - 0.25).abs() < 1e-12);
        // over the whole stretch the rate grows by one and a half per cent, on the straights it doubles
        assert!((get(Metric::HeadingRateRatio) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_stretch_that_is_never_reached_has_no_values() {
        let values = compared(&LateralFigures::default(), &LateralFigures::default(), false);
        assert_eq!((values.get(Metric::LateralBeforeM), values.get(Metric::AsExpected)), (None, Some(0.0)));
    }
}
