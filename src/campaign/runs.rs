//! The table of runs: one row per hold at the test angle, without the values that need a model.

use crate::campaign::{Hold, SampleVerdict, Survey, ledger};
use crate::map::{Gear, RunRow};

/// One row per hold, with the hold itself, for holds with moving samples at the test angle or torque on a wheel at rest there. `verdicts`
/// are those of the survey, or the final ones of a fit; `encoder_scale` is the encoder's reading over the true speed.
///
/// Values from a model (simulated speed, offset) are left empty.
pub(crate) fn runs(survey: &Survey, verdicts: &[SampleVerdict], encoder_scale: f64) -> Vec<(Hold, RunRow)> {
    let encoder = &survey.track.encoder_mps;
    let mut rows = Vec::new();
    for hold in &survey.holds {
        let samples = encoder.range(hold.from_s, hold.to_s);
        let counted =
            |i: usize| !matches!(verdicts[i], SampleVerdict::NoTorque | SampleVerdict::WheelNotAtAngle | SampleVerdict::SteeringMoving);
        if samples.clone().filter(|i| counted(*i)).count() < 5 {
            continue;
        }
        let gear = gear_of(survey, hold);
        let speed_at = |i: usize| {
            let near = encoder.range(encoder.t_s[i] - 0.05, encoder.t_s[i] + 0.05);
            let n = near.len().max(1) as f64;
            gear.sign() * encoder.value[near].iter().sum::<f64>() / n / encoder_scale
        };
        let table = ledger(samples.clone().map(|i| (verdicts[i], survey.seconds[i])));
        let row = RunRow {
            log: survey.track.source.file.clone(),
            wheel_angle_deg: None,
            start_s: round(hold.from_s, 1e3),
            duration_s: round(hold.to_s - hold.from_s, 1e3),
            gear,
            torque_nm: round(gear.sign() * hold.torque_nm, 1e4),
            start_speed_mps: round(speed_at(samples.start), 1e4),
            end_speed_mps: round(speed_at(samples.end - 1), 1e4),
            used_s: table.iter().find(|r| r.verdict == SampleVerdict::Used).map_or(0.0, |r| r.seconds),
            speed_rmse_mps: None,
            r_squared: None,
            offset_mps2: None,
            rejected: table.into_iter().filter(|r| r.verdict != SampleVerdict::Used).collect(),
        };
        rows.push((*hold, row));
    }
    rows
}

/// The gear of a hold: that of the overlapping stretch, otherwise that of the log, otherwise the direction of its torque.
fn gear_of(survey: &Survey, hold: &Hold) -> Gear {
    let stretch = survey.stretches.iter().find(|s| s.from_s < hold.to_s && s.to_s > hold.from_s).map(|s| s.gear);
    let logged = survey.track.gear.as_ref().and_then(|g| g.held(hold.from_s + 0.2)).filter(|g| *g != 0.0);
    let sign = logged.unwrap_or(hold.torque_nm);
    stretch.unwrap_or(if sign < 0.0 { Gear::Reverse } else { Gear::Forward })
}

/// Rounds to 1/`steps`: a report does not need sixteen digits.
fn round(value: f64, steps: f64) -> f64 {
    (value * steps).round() / steps
}
