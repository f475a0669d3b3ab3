//! The metrics of a run: each with its name, unit and definition.

use serde::{Deserialize, Serialize};

/// A metric of one run. "Driving" is the time from the gear being set to the end being reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Metric {
    /// 1 if the run ended as its scenario expects, otherwise 0.
    AsExpected,
    /// |true heading − requested heading| at the end.
    HeadingErrorDeg,
    /// Largest heading beyond the requested one.
    OvershootDeg,
    /// Largest distance of the reference point from where it should be, while driving.
    DriftM,
    /// Root mean square of true speed − planned speed at the wheel's true place, while driving.
    SpeedRmsMps,
    /// Largest of the same.
    SpeedMaxMps,
    /// Largest |first difference of the 20 ms means of the true speed|.
    PeakAccelMps2,
    /// Largest |second difference of the 20 ms means of the true speed|, over the whole pivot.
    PeakJerkMps3,
    /// The same in the first 0.5 s of driving.
    StartJerkMps3,
    /// From the request to success.
    TimeS,
    /// From the gear being set to standstill.
    SettlingTimeS,
    /// Share of driving periods in which the torque command is at its limit.
    SaturatedShare,
    /// Share of driving periods whose look-up is outside the measured region of Table 2.
    OutsideShare,
    /// Largest torque command after a failure in the direction of travel.
    DriveAfterFailureNm,
    /// Arc from the failure to standstill.
    TravelAfterFailureM,
    /// Largest distance of the rear axle's middle from a corner, or from the end of the path, when it rests there.
    CornerErrorM,
    /// Largest distance of the rear axle's middle from the line of a segment while driving.
    SegmentErrorM,
    /// Root mean square of the same over the distance.
    SegmentRmsM,
    /// |mean lateral error| without compensation.
    LateralBeforeM,
    /// |mean lateral error| with it, over the same stretch.
    LateralAfterM,
    /// The second over the first.
    LateralRatio,
    /// RMS of the heading rate with compensation over that without, on the whole stretch or on its straights alone, whichever is larger.
    HeadingRateRatio,
    /// Distance of the rear axle's middle from the path's last pose at the end.
    FinalPositionM,
    /// Smallest distance of the body from anything that it must not touch; negative in a collision.
    ClearanceM,
    /// Reduction of that distance against the planned path.
    ClearanceLossM,
    /// Largest change of the curvature from one pose of the planned path to the next.
    CurvatureStepPerM,
}

impl Metric {
    /// All metrics, in display order.
    pub const ALL: [Self; 26] = [
        Self::AsExpected,
        Self::HeadingErrorDeg,
        Self::OvershootDeg,
        Self::DriftM,
        Self::SpeedRmsMps,
        Self::SpeedMaxMps,
        Self::PeakAccelMps2,
        Self::PeakJerkMps3,
        Self::StartJerkMps3,
        Self::TimeS,
        Self::SettlingTimeS,
        Self::SaturatedShare,
        Self::OutsideShare,
        Self::DriveAfterFailureNm,
        Self::TravelAfterFailureM,
        Self::CornerErrorM,
        Self::SegmentErrorM,
        Self::SegmentRmsM,
        Self::LateralBeforeM,
        Self::LateralAfterM,
        Self::LateralRatio,
        Self::HeadingRateRatio,
        Self::FinalPositionM,
        Self::ClearanceM,
        Self::ClearanceLossM,
        Self::CurvatureStepPerM,
    ];

    /// Display name.
    pub fn title(self) -> &'static str {
        match self {
            Self::AsExpected => "ended as expected",
            Self::HeadingErrorDeg => "final heading error",
            Self::OvershootDeg => "overshoot",
            Self::DriftM => "drift of the reference point",
            Self::SpeedRmsMps => "speed tracking RMS",
            Self::SpeedMaxMps => "speed tracking maximum",
            Self::PeakAccelMps2 => "peak acceleration",
            Self::PeakJerkMps3 => "peak jerk",
            Self::StartJerkMps3 => "start jerk",
            Self::TimeS => "time",
            Self::SettlingTimeS => "settling time",
            Self::SaturatedShare => "torque at its limit",
            Self::OutsideShare => "look-ups outside the measured region",
            Self::DriveAfterFailureNm => "driving torque after the failure",
            Self::TravelAfterFailureM => "travel after the failure",
            Self::CornerErrorM => "corner position error",
            Self::SegmentErrorM => "segment lateral error",
            Self::SegmentRmsM => "segment lateral RMS",
            Self::LateralBeforeM => "mean lateral error before",
            Self::LateralAfterM => "mean lateral error after",
            Self::LateralRatio => "mean lateral error, after over before",
            Self::HeadingRateRatio => "RMS of heading rate, after over before",
            Self::FinalPositionM => "final position error",
            Self::ClearanceM => "smallest clearance",
            Self::ClearanceLossM => "clearance lost in the drive",
            Self::CurvatureStepPerM => "curvature step",
        }
    }

    /// A value with its unit; shares in per cent.
    pub(crate) fn with_unit(self, value: f64) -> String {
        match self.unit() {
            "" => format!("{:.1} %", 100.0 * value),
            "°" => format!("{value:.2}°"),
            unit => format!("{value:.3} {unit}"),
        }
    }

    /// Display unit; empty for a share.
    pub fn unit(self) -> &'static str {
        match self {
            Self::AsExpected | Self::SaturatedShare | Self::OutsideShare => "",
            Self::HeadingErrorDeg | Self::OvershootDeg => "°",
            Self::LateralRatio | Self::HeadingRateRatio => "×",
            Self::DriftM
            | Self::TravelAfterFailureM
            | Self::CornerErrorM
            | Self::SegmentErrorM
            | Self::SegmentRmsM
            | Self::LateralBeforeM
            | Self::LateralAfterM
            | Self::FinalPositionM
            | Self::ClearanceM
            | Self::ClearanceLossM => "m",
            Self::CurvatureStepPerM => "1/m",
            Self::SpeedRmsMps | Self::SpeedMaxMps => "m/s",
            Self::PeakAccelMps2 => "m/s²",
            Self::PeakJerkMps3 | Self::StartJerkMps3 => "m/s³",
            Self::TimeS | Self::SettlingTimeS => "s",
            Self::DriveAfterFailureNm => "N·m",
        }
    }
}

/// Statistic of a metric over the draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Statistic {
    /// The run on the fitted plant, without any perturbation.
    Nominal,
    /// Mean over the draws.
    Mean,
    /// Half of the draws are at or below this value.
    Median,
    /// 95 of 100 draws are at or below this value.
    P95,
    /// 99 of 100 draws are at or below this value.
    P99,
    /// The largest of the draws.
    Max,
}

impl Statistic {
    /// Display name.
    pub fn title(self) -> &'static str {
        match self {
            Self::Nominal => "nominal",
            Self::Mean => "mean",
            Self::Median => "median",
            Self::P95 => "95 %",
            Self::P99 => "99 %",
            Self::Max => "max",
        }
    }
}

/// The values of one run, `None` where a metric has no meaning for it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Values([Option<f64>; Metric::ALL.len()]);

impl Values {
    /// The value of a metric.
    pub fn get(&self, metric: Metric) -> Option<f64> {
        self.0[metric as usize]
    }

    /// Sets the value of a metric; a value that is not finite counts as absent.
    pub fn set(&mut self, metric: Metric, value: f64) {
        self.0[metric as usize] = Some(value).filter(|v| v.is_finite());
    }
}

/// A metric over the draws of a scenario.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MetricSummary {
    /// Which.
    pub metric: Metric,
    /// On the fitted plant.
    pub nominal: Option<f64>,
    /// Mean of the draws.
    pub mean: Option<f64>,
    /// Median of the draws.
    pub median: Option<f64>,
    /// 95th percentile.
    pub p95: Option<f64>,
    /// 99th percentile.
    pub p99: Option<f64>,
    /// Largest.
    pub max: Option<f64>,
}

impl MetricSummary {
    /// The statistics of every metric that any of the runs has, in the order of [`Metric::ALL`].
    pub(crate) fn all(nominal: &Values, draws: &[Values]) -> Vec<Self> {
        Metric::ALL.into_iter().filter_map(|metric| Self::new(metric, nominal, draws)).collect()
    }

    /// The statistics of the nominal run and the draws, in any order. `None` when no run has the metric.
    pub fn new(metric: Metric, nominal: &Values, draws: &[Values]) -> Option<Self> {
        let nominal = nominal.get(metric);
        let mut values: Vec<f64> = draws.iter().filter_map(|d| d.get(metric)).collect();
        values.sort_by(f64::total_cmp);
        if nominal.is_none() && values.is_empty() {
            return None;
        }
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64);
        let at = |share: f64| quantile(&values, share);
        Some(Self { metric, nominal, mean, median: at(0.5), p95: at(0.95), p99: at(0.99), max: values.last().copied() })
    }

    /// One of its statistics.
    pub fn figure(&self, statistic: Statistic) -> Option<f64> {
        match statistic {
            Statistic::Nominal => self.nominal,
            Statistic::Mean => self.mean,
            Statistic::Median => self.median,
            Statistic::P95 => self.p95,
            Statistic::P99 => self.p99,
            Statistic::Max => self.max,
        }
    }
}

/// Quantile of sorted values by linear interpolation between order statistics. Source: Hyndman & Fan (1996), type 7.
pub(crate) fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let position = share * last as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(last);
    Some(sorted[below] + (position - below as f64) * (sorted[above] - sorted[below]))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn quantiles_interpolate_between_order_statistics() {
        let sorted = [1.0, 2.0, 3.0, 4.0];
        assert_eq!(quantile(&sorted, 0.5), Some(2.5));
        assert_eq!(quantile(&sorted, 1.0), Some(4.0));
        assert_eq!(quantile(&[], 0.5), None);
    }

    #[test]
    fn the_metrics_are_listed_in_the_order_of_their_numbers() {
        assert!(Metric::ALL.iter().enumerate().all(|(k, &m)| m as usize == k));
    }
}
