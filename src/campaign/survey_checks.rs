//! What the signals of a log show before there is a fit → checks: the encoder against the yaw rate, and the speed at rest.

use crate::campaign::survey::Survey;
use crate::check::campaign_checks::scale_check;
use crate::map::{Check, CheckOutcome, SampleVerdict};
use crate::signal::median;

/// Slower than this, noise makes most of a ratio of two speeds [m/s].
const SLOWEST_MPS: f64 = 0.15;
/// Fewest readings that show a ratio or an offset.
const FEWEST: usize = 50;
/// Offset of the encoder at rest for a warning and for an objection [m/s]: a step of a coarse encoder is not an offset, a wheel that creeps at
/// 3 cm/s is not at rest.
const AT_REST_MPS: [f64; 2] = [0.01, 0.03];

impl Survey {
    /// The checks of one log's signals.
    pub(crate) fn checks(&self) -> Vec<Check> {
        let scale = self.encoder_scale().map(|scale| scale_check(&self.track.vehicle, scale));
        scale.into_iter().chain(self.speed_at_rest()).collect()
    }

    /// Median ratio of the encoder's speed to that of the yaw rate. `None` without a yaw rate or with few readings in motion.
    fn encoder_scale(&self) -> Option<f64> {
        let (encoder, yaw) = (&self.track.encoder_mps, self.track.yaw_speed_mps.as_ref()?);
        let used = (0..encoder.len()).filter(|k| self.verdicts[*k] == SampleVerdict::Used && encoder.value[*k].abs() > SLOWEST_MPS);
        let ratios: Vec<f64> = used
            .filter_map(|k| Some(encoder.value[k] / (yaw.interpolated(encoder.t_s[k])? - self.yaw_bias_mps)))
            .filter(|ratio| ratio.is_finite())
            .collect();
        (ratios.len() >= FEWEST).then(|| median(&ratios))
    }

    /// The encoder's median at rest. `None` where the wheel was hardly at rest.
    pub(crate) fn speed_at_rest(&self) -> Option<Check> {
        let encoder = &self.track.encoder_mps;
        let is_rest = |k: &usize| matches!(self.verdicts[*k], SampleVerdict::AtRest | SampleVerdict::NoTorque);
        let readings: Vec<f64> = (0..encoder.len()).filter(is_rest).map(|k| encoder.value[k]).collect();
        if readings.len() < FEWEST {
            return None;
        }
        let offset_mps = median(&readings);
        let (outcome, limit) = CheckOutcome::graded(offset_mps.abs(), AT_REST_MPS);
        let meaning = format!("{}: at rest the speed reads {offset_mps:.3} m/s, {limit:.2} m/s is allowed", self.track.source.file);
        let check = Check::passed("speed-at-rest", (offset_mps.abs(), limit, "m/s"), meaning);
        Some(check.judged(outcome, "give the `offset` of the speed in the signal map, or mend the sensor"))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::campaign::SurveySettings;
    use crate::log::{Source, VehicleOverrides, read_bytes};
    use crate::signal::Track;

    /// The demo's checks with another wheelbase and an offset of the speed.
    fn checks(wheelbase_m: f64, offset_mps: f64) -> Vec<Check> {
        let overrides = VehicleOverrides { wheelbase_m: Some(wheelbase_m), ..VehicleOverrides::default() };
        let log = read_bytes(include_bytes!("../../data/demo.mcap").to_vec(), "demo.mcap", &Source::Detect, &overrides).unwrap();
        let mut survey = Survey::new(Track::new(&log).unwrap(), &SurveySettings::default()).unwrap();
        survey.track.encoder_mps.value.iter_mut().for_each(|v| *v += offset_mps);
        survey.checks()
    }

    #[test]
    fn a_wrong_wheelbase_and_an_offset_at_rest_are_seen_without_a_fit() {
        let good = checks(0.9, 0.0);
        let names: Vec<&str> = good.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["encoder-scale", "speed-at-rest"]);
        assert!(good.iter().all(|c| c.outcome == CheckOutcome::Passed), "{good:?}");
        assert!((good[0].figure - 0.4).abs() < 0.2, "{}", good[0].meaning);
        let long = checks(1.2, 0.0);
        assert!(long[0].objects() && long[0].advice.contains("0.90"), "{}", long[0].text());
        assert_eq!(checks(0.9, 0.015)[1].outcome, CheckOutcome::Warning);
        assert!(checks(0.9, -0.05)[1].objects());
    }
}
