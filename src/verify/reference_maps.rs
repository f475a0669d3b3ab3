//! The maps that a perfect campaign would give of a vehicle whose physics is known: for examples, benchmarks and tests.

use crate::control::TorqueFromAccel as _;
use crate::map::{
    AccelMap, AccelTable, Actuator, ActuatorInput, Axis, BreakawayTorque, CellStatus, CsvRef, DeadBand, DelayEstimate, DelayStatus,
    FORMAT_VERSION, FineSurface, Gear, PlantNoise, RoundTripErrors, RunRow, Stage1Report, TABLE1_FORMAT, TABLE2_FORMAT, Table1File,
    Table2File, TorqueMap, TorqueTable, Units, ZeroRow, sha256_hex,
};
use crate::sim::WorldSettings;
use crate::verify::Result;
use crate::verify::exact_map::{ExactMap, torque_for};

/// Fastest speed of the maps [m/s].
const FASTEST_MPS: f64 = 1.0;

/// Table 1 and Table 2 of the world's exact map, both gears, every cell measured, with the breaks that `fit` and `invert` use by
/// default: speed every 0.05 m/s, torque every 4 N·m, acceleration every 0.1 m/s².
///
/// # Errors
/// A world that cannot be simulated.
pub fn known_maps(world: &WorldSettings) -> Result<(Table1File, Table2File)> {
    let plant = ExactMap::new(world)?;
    let delay = |value_s| DelayEstimate { value_s, std_err_s: None, status: DelayStatus::Given };
    let mut table1 = Table1File {
        format: TABLE1_FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        generation: String::new(),
        units: Units::default(),
        vehicle: world.vehicle,
        torque_limit_driven: false,
        logs: Vec::new(),
        settings: serde_json::Value::Null,
        actuator: Actuator {
            dead_time: delay(world.drive.dead_time_s),
            lag: delay(world.drive.lag_s),
            input: ActuatorInput::COMMAND,
            drive: None,
            changes: Vec::new(),
            per_log: Vec::new(),
        },
        witnesses: Vec::new(),
        noise: PlantNoise {
            disturbance_mps2: 0.03,
            disturbance_time_s: 0.3,
            run_offset_mps2: 0.02,
            speed_noise_mps: 0.006,
            speed_step_mps: 0.0,
        },
        maps: Vec::new(),
        families: Vec::new(),
        checks: Vec::new(),
        report: Stage1Report { coverage: 1.0, ..Stage1Report::default() },
    };
    for gear in Gear::ALL {
        if let Some(exact) = plant.table(gear) {
            let map = accel_map(gear, exact, &plant, world)?;
            table1.report.runs.extend(map.torque_nm.iter().map(|torque_nm| perfect_run(gear, *torque_nm)));
            table1.maps.push(map);
        }
    }
    let table1 = table1.with_generation()?;
    let mut table2 = Table2File {
        format: TABLE2_FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: table1.tool_version.clone(),
        generation: table1.generation.clone(),
        unverified: None,
        raw: None,
        units: Units::default(),
        vehicle: world.vehicle,
        logs: Vec::new(),
        table1: CsvRef { file: "table1.json".to_owned(), sha256: sha256_hex(table1.to_json()?.as_bytes()) },
        settings: serde_json::Value::Null,
        dead_time_s: world.drive.dead_time_s,
        lag_s: world.drive.lag_s,
        drive: None,
        maps: Vec::new(),
        families: Vec::new(),
    };
    for gear in Gear::ALL {
        if let Some(exact) = plant.table(gear) {
            table2.maps.push(torque_map(gear, exact, &plant, world)?);
        }
    }
    Ok((table1, table2))
}

/// A run of 10 s under one torque, all of it used.
fn perfect_run(gear: Gear, torque_nm: f64) -> RunRow {
    RunRow {
        log: "exact".to_owned(),
        wheel_angle_deg: None,
        start_s: 0.0,
        duration_s: 10.0,
        gear,
        torque_nm,
        start_speed_mps: 0.0,
        end_speed_mps: 0.0,
        used_s: 10.0,
        speed_rmse_mps: None,
        r_squared: None,
        offset_mps2: None,
        rejected: Vec::new(),
    }
}

fn accel_map(gear: Gear, exact: &AccelTable, plant: &ExactMap, world: &WorldSettings) -> Result<AccelMap> {
    let speed = Axis::uniform("speed_mps", 0.0, 0.05, FASTEST_MPS)?;
    let torque = Axis::uniform("torque_nm", -plant.limit_nm(), 4.0, plant.limit_nm())?;
    let fine = Axis::uniform("speed_mps", 0.0, 0.01, FASTEST_MPS)?;
    let rows = |speed: &Axis, torque: &Axis| -> Vec<Vec<f64>> {
        let row = |u: &f64| speed.breaks().iter().map(|&v| exact.accel_from_torque_clamped(v, *u).unwrap_or_default()).collect();
        torque.breaks().iter().map(row).collect()
    };
    let accel_mps2 = rows(&speed, &torque);
    let table = AccelTable::new(speed.clone(), torque.clone(), accel_mps2.concat())?;
    let (m, n) = (torque.len(), speed.len());
    let breakaway_nm = torque_for(exact, 0.0, 0.0).map_or(0.0, |(torque_nm, _)| torque_nm);
    Ok(AccelMap {
        gear,
        wheel_angle_deg: world.vehicle.test_angle_deg,
        csv: CsvRef { file: format!("table1{}.csv", gear.file_infix()), sha256: sha256_hex(table.to_matrix().to_csv().as_bytes()) },
        speed_mps: speed.breaks().to_vec(),
        torque_nm: torque.breaks().to_vec(),
        accel_mps2,
        std_err_mps2: vec![vec![0.01; n]; m],
        count: vec![vec![100; n]; m],
        confidence: vec![vec![1.0 / 1.01; n]; m],
        status: vec![vec![CellStatus::Measured; n]; m],
        measured_torque_nm: vec![Some([torque.first(), torque.last()]); n],
        breakaway: BreakawayTorque {
            torque_nm: breakaway_nm,
            std_err_nm: Some(0.1),
            at_rest_up_to_nm: Some(breakaway_nm - 0.1),
            moved_from_nm: Some(breakaway_nm + 0.1),
        },
        surface: FineSurface {
            speed_mps: fine.breaks().to_vec(),
            torque_nm: exact.torque_nm().breaks().to_vec(),
            accel_mps2: rows(&fine, exact.torque_nm()),
        },
    })
}

fn torque_map(gear: Gear, exact: &AccelTable, plant: &ExactMap, world: &WorldSettings) -> Result<TorqueMap> {
    let speed = Axis::uniform("speed_mps", 0.0, 0.05, FASTEST_MPS)?;
    let ends =
        |v: f64| [exact.torque_nm().first(), exact.torque_nm().last()].map(|u| exact.accel_from_torque_clamped(v, u).unwrap_or_default());
    let reach: Vec<[f64; 2]> = speed.breaks().iter().map(|&v| ends(v)).collect();
    let lowest = reach.iter().fold(0.0, |low: f64, r| low.min(r[0]));
    let highest = reach.iter().fold(0.0, |high: f64, r| high.max(r[1]));
    let accel = Axis::uniform("accel_mps2", (lowest * 10.0).floor() / 10.0, 0.1, (highest * 10.0).ceil() / 10.0)?;
    let (mut torque_nm, mut status) = (Vec::new(), Vec::new());
    for &v in speed.breaks() {
        let row: Vec<_> = accel.breaks().iter().filter_map(|&a| plant.torque(gear, v, a)).collect();
        torque_nm.push(row.iter().map(|found| found.torque_nm).collect::<Vec<_>>());
        status.push(row.iter().map(|found| if found.outside { CellStatus::Unreachable } else { CellStatus::Measured }).collect::<Vec<_>>());
    }
    let table = TorqueTable::new(speed.clone(), accel.clone(), torque_nm.concat())?;
    let std_err_nm = status.iter().map(|row| row.iter().map(|&s| (s == CellStatus::Measured).then_some(0.15)).collect()).collect();
    let breakaway_nm = torque_for(exact, 0.0, 0.0).map_or(0.0, |(torque_nm, _)| torque_nm);
    let nowhere = crate::map::GridPoint::default();
    Ok(TorqueMap {
        gear,
        wheel_angle_deg: world.vehicle.test_angle_deg,
        csv: CsvRef { file: format!("table2{}.csv", gear.file_infix()), sha256: sha256_hex(table.to_matrix().to_csv().as_bytes()) },
        speed_mps: speed.breaks().to_vec(),
        accel_mps2: accel.breaks().to_vec(),
        torque_nm,
        std_err_nm,
        status,
        reachable_accel_mps2: reach,
        dead_band: DeadBand { low_nm: -breakaway_nm, high_nm: breakaway_nm, std_err_nm: Some(0.1) },
        zero_row: ZeroRow::Moving,
        round_trip: RoundTripErrors {
            node_rms_mps2: 0.0,
            node_max_mps2: 0.0,
            node_max_at: nowhere,
            between_rms_mps2: 0.0,
            between_max_mps2: 0.0,
            between_max_at: nowhere,
        },
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::sim::{Truth, VehicleFile};
    use crate::units::RAD_PER_DEG;

    #[test]
    fn both_maps_are_those_of_the_vehicle_and_belong_together() {
        let vehicle = VehicleFile::bundled().unwrap();
        let (table1, table2) = known_maps(&vehicle.settings()).unwrap();
        let truth: Truth = vehicle.truth().unwrap();
        let angle_rad = vehicle.vehicle.test_angle_deg * RAD_PER_DEG;
        assert_eq!(table1.maps.iter().map(|m| m.gear).collect::<Vec<_>>(), Gear::ALL);
        for (accel, torque) in table1.maps.iter().zip(&table2.maps) {
            let of = |v: f64, u: f64| truth.gear_accel_mps2(accel.gear, v, u, angle_rad);
            for (i, u) in accel.torque_nm.iter().enumerate() {
                for (j, v) in accel.speed_mps.iter().enumerate().skip(1) {
                    // lines between the nodes of the fine grid
                    assert!((accel.accel_mps2[i][j] - of(*v, *u)).abs() < 2e-3, "{v} m/s, {u} N·m");
                }
            }
            for (i, v) in torque.speed_mps.iter().enumerate().skip(1) {
                for (j, a) in torque.accel_mps2.iter().enumerate().filter(|(j, _)| torque.status[i][*j] == CellStatus::Measured) {
                    assert!((of(*v, torque.torque_nm[i][j]) - a).abs() < 2e-3, "{v} m/s, {a} m/s²");
                }
            }
            assert_eq!(torque.dead_band.high_nm, accel.breakaway.torque_nm);
        }
        assert_eq!(table2.table1.sha256, sha256_hex(table1.to_json().unwrap().as_bytes()));
        assert_eq!(Table1File::from_json(&table1.to_json().unwrap()).unwrap(), table1);
        assert_eq!(Table2File::from_json(&table2.to_json().unwrap()).unwrap(), table2);
    }
}
