//! Open-loop replay: a plant without random parts is driven with the torque of a recorded run and compared with the recorded speed.
//!
//! The simulated speed is never corrected, so an error of the map appears as a drift: this is the strictest test of a fit.

use crate::sim::drive::Drive;
use crate::sim::error::{Error, Result};
use crate::sim::load::Load;
use crate::sim::motion::Motion;
use crate::sim::settings::{Perturbation, WorldSettings};
use crate::sim::{Gear, WheelAngleTerms};
use crate::units::RAD_PER_DEG;

/// A recorded run, gear frame. The slices have equal lengths and ascending times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RecordedRun<'a> {
    /// Gear.
    pub gear: Gear,
    /// Times [s]. They should begin a dead time and some lags before `score_from_s`, for the effective torque at that instant.
    pub t_s: &'a [f64],
    /// Commanded torque [N·m], valid from its time to the next; the first one is assumed to be valid for all time before.
    pub torque_nm: &'a [f64],
    /// Recorded speed [m/s].
    pub speed_mps: &'a [f64],
    /// Start of the simulation and the comparison [s]: the simulation starts there with the recorded speed.
    pub score_from_s: f64,
}

/// A replay and its errors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Replay {
    /// Index of the first compared sample.
    pub first: usize,
    /// Simulated speed at the samples from `first` on [m/s].
    pub speed_mps: Vec<f64>,
    /// Root mean square of simulated minus recorded [m/s].
    pub rmse_mps: f64,
    /// Largest difference [m/s].
    pub max_mps: f64,
    /// 1 − SSE/SST: share of the recorded speed's variance explained by the simulation; `None` if the speed does not vary.
    pub r_squared: Option<f64>,
}

/// Replays `run` through the plant of `settings`, at its test angle.
///
/// # Errors
/// The slices have different lengths, fewer than two samples are compared, or a setting is out of its range.
pub(crate) fn replay(settings: &WorldSettings, run: &RecordedRun<'_>) -> Result<Replay> {
    let n = run.t_s.len();
    let first = run.t_s.partition_point(|&t| t < run.score_from_s);
    if run.torque_nm.len() != n || run.speed_mps.len() != n || first + 2 > n {
        return Err(Error::UnequalRun { t_s: n.saturating_sub(first), torque_nm: run.torque_nm.len(), speed_mps: run.speed_mps.len() });
    }
    let quiet = settings.perturbed(&Perturbation { noise_factor: 0.0, ..Perturbation::default() })?;
    let (step_s, sign) = (quiet.step_s, run.gear.sign());
    let mut drive = Drive::new(&quiet.drive, step_s)?;
    let mut motion = Motion::new(&quiet.motion, &quiet.vehicle, step_s, 0)?;
    motion.set_angle(&WheelAngleTerms::fixed(quiet.vehicle.test_angle_deg * RAD_PER_DEG));
    drive.settle(sign * run.torque_nm[0]);
    let mut speed_mps = Vec::with_capacity(n - first);
    let (mut t_s, mut steps, mut command) = (run.t_s[0], 0_u64, 0);
    let mut before = (t_s, 0.0);
    for k in first..n {
        if k == first {
            // up to the first compared sample, only the drive runs
            while t_s + step_s <= run.t_s[first] {
                command = in_force(run.t_s, command, t_s);
                drive.step(sign * run.torque_nm[command]);
                steps += 1;
                t_s = run.t_s[0] + steps as f64 * step_s;
            }
            motion.set_speed(sign * run.speed_mps[first].max(0.0));
            before = (t_s, sign * motion.speed_mps());
        }
        while t_s < run.t_s[k] {
            before = (t_s, sign * motion.speed_mps());
            command = in_force(run.t_s, command, t_s);
            let torque = drive.step(sign * run.torque_nm[command]);
            motion.step(&Load { torque, external_nm: 0.0, brake_nm: 0.0, gear: Some(run.gear) });
            steps += 1;
            t_s = run.t_s[0] + steps as f64 * step_s;
        }
        let now_mps = sign * motion.speed_mps();
        let part = if t_s > before.0 { ((run.t_s[k] - before.0) / (t_s - before.0)).clamp(0.0, 1.0) } else { 1.0 };
        speed_mps.push(before.1 + part * (now_mps - before.1));
    }
    Ok(compared(first, speed_mps, &run.speed_mps[first..]))
}

/// Index of the valid command at `t_s`, at or after `from`.
fn in_force(times_s: &[f64], from: usize, t_s: f64) -> usize {
    let mut k = from;
    // tolerance of a nanosecond: step times are sums, sample times are logged
    while k + 1 < times_s.len() && times_s[k + 1] <= t_s + 1e-9 {
        k += 1;
    }
    k
}

fn compared(first: usize, simulated: Vec<f64>, recorded: &[f64]) -> Replay {
    let n = recorded.len() as f64;
    let mean = recorded.iter().sum::<f64>() / n;
    let sse: f64 = simulated.iter().zip(recorded).map(|(s, r)| (s - r).powi(2)).sum();
    let sst: f64 = recorded.iter().map(|r| (r - mean).powi(2)).sum();
    let max_mps = simulated.iter().zip(recorded).map(|(s, r)| (s - r).abs()).fold(0.0, f64::max);
    Replay { first, speed_mps: simulated, rmse_mps: (sse / n).sqrt(), max_mps, r_squared: (sst > 0.0).then_some(1.0 - sse / sst) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::{AccelTable, Axis, Vehicle};
    use crate::sim::sensor_settings::SensorSettings;
    use crate::sim::{GearSurface, IdentifiedSettings, MotionSettings, PhysicalSettings, Truth, World, WorldCommand};

    fn vehicle() -> Vehicle {
        Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None }
    }

    /// The physical plant's true map in the form of a fit, with torques multiplied by `scale`.
    fn identified(scale: f64) -> WorldSettings {
        let physical = PhysicalSettings::default();
        let truth = Truth::new(&physical, &vehicle()).unwrap();
        let direction = |gear| {
            let speed = Axis::uniform("speed", 0.0, 0.01, 2.0).unwrap();
            let torque = Axis::uniform("torque", -44.0, 1.0, 44.0).unwrap();
            let angle = std::f64::consts::FRAC_PI_2;
            let accel = |u: f64, v: f64| truth.gear_accel_mps2(gear, v, scale * u, angle);
            let values = torque.breaks().iter().flat_map(|&u| speed.breaks().iter().map(move |&v| accel(u, v))).collect();
            GearSurface { table: AccelTable::new(speed, torque, values).unwrap(), breakaway_nm: truth.breakaway_nm(gear, angle) / scale }
        };
        let motion = IdentifiedSettings {
            forward: direction(Gear::Forward),
            reverse: Some(direction(Gear::Reverse)),
            power_limit_nm_mps: f64::INFINITY,
            disturbance_mps2: 0.1,
            disturbance_time_s: 0.2,
            run_offset_mps2: 0.1,
            slope_share: 0.5,
            wheel_mass_kg: 6.0,
        };
        let motion = MotionSettings::Identified(Box::new(motion));
        WorldSettings { motion, ..WorldSettings::physical(vehicle(), physical) }
    }

    /// A run of the physical plant: half a second of rest, 24 N·m, then coasting to rest, sampled at 50 Hz.
    fn recorded(gear: Gear) -> [Vec<f64>; 3] {
        let mut settings = WorldSettings::physical(vehicle(), PhysicalSettings::default());
        settings.sensors = SensorSettings::ideal();
        let mut world = World::new(&settings, 1).unwrap();
        let wheel_angle_rad = std::f64::consts::FRAC_PI_2;
        world.place_wheel(wheel_angle_rad);
        let mut rows = [const { Vec::new() }; 3];
        for k in 0..250 {
            let torque = if (25..100).contains(&k) { 24.0 } else { 0.0 };
            for (row, value) in rows.iter_mut().zip([world.state().t_s, torque, gear.sign() * world.state().speed_mps]) {
                row.push(value);
            }
            for _ in 0..20 {
                world.step(&WorldCommand { torque_nm: gear.sign() * torque, wheel_angle_rad, gear: Some(gear) });
            }
        }
        rows
    }

    #[test]
    fn the_true_map_replays_the_run_and_a_wrong_one_does_not() {
        for gear in Gear::ALL {
            let [t_s, torque_nm, speed_mps] = recorded(gear);
            let run = RecordedRun { gear, t_s: &t_s, torque_nm: &torque_nm, speed_mps: &speed_mps, score_from_s: 0.3 };
            let right = replay(&identified(1.0), &run).unwrap();
            // the grid of 0.01 m/s and 1 N·m interpolates the friction curve with an error of some mm/s²
            assert!(right.rmse_mps < 2e-3 && right.r_squared.unwrap() > 0.9999, "{gear}: {} m/s", right.rmse_mps);
            assert_eq!((right.first, right.speed_mps.len()), (15, 235));
            let wrong = replay(&identified(1.1), &run).unwrap();
            assert!(wrong.rmse_mps > 0.05 && wrong.r_squared < right.r_squared, "{gear}: {} m/s", wrong.rmse_mps);
        }
    }

    #[test]
    fn a_replay_can_start_in_motion() {
        let [t_s, torque_nm, speed_mps] = recorded(Gear::Forward);
        let run = RecordedRun { gear: Gear::Forward, t_s: &t_s, torque_nm: &torque_nm, speed_mps: &speed_mps, score_from_s: 1.5 };
        let result = replay(&identified(1.0), &run).unwrap();
        assert!(result.rmse_mps < 2e-3, "{} m/s", result.rmse_mps);
    }

    #[test]
    fn slices_of_different_lengths_are_refused() {
        let run = RecordedRun { gear: Gear::Forward, t_s: &[0.0, 1.0], torque_nm: &[0.0], speed_mps: &[0.0, 0.0], score_from_s: 0.0 };
        assert!(matches!(replay(&identified(1.0), &run), Err(Error::UnequalRun { torque_nm: 1, .. })));
    }
}
