//! Diagnostics of the estimate besides the tables: speed sources, noise, and how the surface was chosen.

use crate::fit::rounds::cross_validation::ModelComparison;
use crate::fit::rounds::estimate::Estimate;
use crate::fit::solve::monotone;
use crate::fit::table1::runs::round;
use crate::map::{PlantNoise, SpeedReading, SpeedSource};
use crate::signal::median;

/// The random part of the plant.
pub(crate) fn plant_noise(estimate: &Estimate) -> PlantNoise {
    PlantNoise {
        disturbance_mps2: round(estimate.noise.disturbance_mps2, 1e6),
        disturbance_time_s: round(estimate.noise.disturbance_time_s, 1e6),
        run_offset_mps2: round(estimate.noise.offset_mps2, 1e6),
        speed_noise_mps: round(estimate.noise.reading_mps[0], 1e6),
        speed_step_mps: round(estimate.data.logs.iter().map(|log| log.coarse_mps[0]).fold(0.0, f64::max), 1e6),
    }
}

/// The speed sources, encoder first.
pub(crate) fn speed_readings(estimate: &Estimate) -> Vec<SpeedReading> {
    let encoder = SpeedReading {
        name: SpeedSource::Encoder,
        scale: round(estimate.calibration.encoder_scale, 1e6),
        scale_std_err: estimate.data.has_yaw.then(|| round(estimate.calibration_errors.encoder_scale, 1e6)),
        delay_s: round(estimate.calibration.encoder_delay_s, 1e6),
        noise_mps: round(estimate.noise.reading_mps[0], 1e6),
    };
    let mut all = vec![encoder];
    if estimate.data.has_yaw {
        all.push(SpeedReading {
            name: SpeedSource::YawRate,
            scale: 1.0,
            scale_std_err: None,
            delay_s: 0.0,
            noise_mps: round(estimate.noise.reading_mps[1], 1e6),
        });
    }
    all
}

/// The surface's coefficients and penalties, the cross-validation, and how it was made to rise with torque.
pub(crate) fn diagnostics(estimate: &Estimate, moved: monotone::MonotoneOutcome, pooled: Option<(f64, f64)>) -> serde_json::Value {
    let innovations: Vec<f64> = estimate.paths.white.iter().flatten().map(|e| e.abs()).collect();
    let blocks: Vec<serde_json::Value> = estimate
        .model
        .design
        .blocks
        .iter()
        .zip(estimate.model.stacked.solution.penalties.iter().zip(&estimate.model.stacked.solution.degrees))
        .map(|(block, (penalty, degrees))| {
            serde_json::json!({
                "block": block.name,
                "coefficients": block.range.len(),
                "effective": round(*degrees, 1e3),
                "penalty": if block.penalised && penalty.is_finite() { serde_json::json!(penalty) } else { serde_json::Value::Null },
            })
        })
        .collect();
    let model_choice = estimate.validation.as_ref().map(|v| {
        let ModelComparison { gain, in_std_errs, runs, surface_share } = v.comparison;
        serde_json::json!({
            "surface_share": round(surface_share, 1e3),
            "gain_of_surface": round(gain, 1e3),
            "in_std_errs": round(in_std_errs, 1e2),
            "runs": runs,
        })
    });
    let held_out = pooled.zip(estimate.validation.as_ref()).map(|((rmse_mps, r_squared), v)| {
        serde_json::json!({ "rmse": round(rmse_mps, 1e5), "r_squared": round(r_squared, 1e5), "folds": v.without.len() })
    });
    serde_json::json!({
        "model_choice": model_choice,
        "held_out": held_out,
        "stribeck_speed_mps": round(estimate.model.design.stribeck_mps, 1e6),
        "blocks": blocks,
        "penalties_settled": estimate.model.stacked.solution.settled,
        "monotone": match moved {
            monotone::MonotoneOutcome::AlreadyMonotone => "by itself".to_owned(),
            monotone::MonotoneOutcome::Moved(n) => format!("{n} differences bind"),
            monotone::MonotoneOutcome::Forced => "forced".to_owned(),
        },
        "innovation_scale": round(median(&innovations) / 0.674_489_750_196_082, 1e4),
    })
}
