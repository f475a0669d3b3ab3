//! What holds for any table: its inverse undoes it, rises, and stays within the torque limit.

#![allow(clippy::unwrap_used)]

use pivot_cal::invert::{InvertSettings, invert};
use pivot_cal::map::{
    AccelMap, Actuator, ActuatorInput, BreakawayTorque, CellStatus, CsvRef, DelayEstimate, DelayStatus, FineSurface, Gear, PlantNoise,
    Stage1Report, Table1File, Units, Vehicle, ZeroRow,
};
use proptest::prelude::*;

/// A rising surface: acceleration falls with speed and rises with torque, each by random steps.
fn surfaces() -> impl Strategy<Value = Vec<Vec<f64>>> {
    let rises = prop::collection::vec(prop::collection::vec(0.05..0.4f64, 12), 8);
    let falls = prop::collection::vec(0.0..0.3f64, 12);
    (rises, falls).prop_map(|(rises, falls)| {
        let mut rows = Vec::new();
        let mut base: Vec<f64> = falls.iter().scan(-1.0, |sum, f| Some(std::mem::replace(sum, *sum - f))).collect();
        for rise in rises {
            rows.push(base.clone());
            base.iter_mut().zip(&rise).for_each(|(b, r)| *b += r);
        }
        rows
    })
}

fn file(accel: &[Vec<f64>]) -> Table1File {
    let speed_mps: Vec<f64> = (0..12).map(|k| f64::from(k) * 0.1).collect();
    let torque_nm: Vec<f64> = (0..8).map(|k| f64::from(k - 2) * 8.0).collect();
    let delay = DelayEstimate { value_s: 0.05, std_err_s: None, status: DelayStatus::Given };
    let map = AccelMap {
        gear: Gear::Forward,
        wheel_angle_deg: 90.0,
        csv: CsvRef { file: "table1.csv".into(), sha256: String::new() },
        std_err_mps2: vec![vec![0.01; 12]; 8],
        count: vec![vec![9; 12]; 8],
        confidence: vec![vec![1.0; 12]; 8],
        status: vec![vec![CellStatus::Measured; 12]; 8],
        measured_torque_nm: vec![Some([-16.0, 40.0]); 12],
        breakaway: BreakawayTorque { torque_nm: 6.0, std_err_nm: None, at_rest_up_to_nm: None, moved_from_nm: None },
        surface: FineSurface { speed_mps: speed_mps.clone(), torque_nm: torque_nm.clone(), accel_mps2: accel.to_vec() },
        accel_mps2: accel.to_vec(),
        speed_mps,
        torque_nm,
    };
    Table1File {
        format: "pivot-cal/table1".into(),
        format_version: 1,
        tool_version: "0".into(),
        generation: String::new(),
        units: Units::default(),
        vehicle: Vehicle {
            wheelbase_m: 0.9,
            wheel_radius_m: 0.12,
            test_angle_deg: 90.0,
            torque_limit_nm: Some(44.0),
            torque_full_scale_nm: None,
        },
        torque_limit_driven: false,
        logs: Vec::new(),
        settings: serde_json::Value::Null,
        actuator: Actuator {
            dead_time: delay.clone(),
            lag: delay,
            input: ActuatorInput::COMMAND,
            drive: None,
            changes: Vec::new(),
            per_log: Vec::new(),
        },
        witnesses: Vec::new(),
        noise: PlantNoise {
            disturbance_mps2: 0.0,
            disturbance_time_s: 0.3,
            run_offset_mps2: 0.0,
            speed_noise_mps: 0.0,
            speed_step_mps: 0.0,
        },
        maps: vec![map],
        families: Vec::new(),
        checks: Vec::new(),
        report: Stage1Report::default(),
    }
}

fn table1() -> CsvRef {
    CsvRef { file: "table1.json".into(), sha256: String::new() }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn the_inverse_rises_with_acceleration_and_keeps_the_torque_limit(accel in surfaces()) {
        let inversion = invert(&file(&accel), table1(), &InvertSettings::default()).unwrap();
        for row in &inversion.file.maps[0].torque_nm {
            prop_assert!(row.windows(2).all(|w| w[1] >= w[0]));
            prop_assert!(row.iter().all(|t| t.abs() <= 44.0));
        }
    }

    #[test]
    fn node_exact_tables_undo_the_surface_at_their_nodes(accel in surfaces()) {
        let settings = InvertSettings { node_exact: true, ..InvertSettings::default() };
        let inversion = invert(&file(&accel), table1(), &settings).unwrap();
        // values are stored to a millionth of a newton metre; slopes here are at most 0.05 m/s² per N·m
        prop_assert!(inversion.file.maps[0].round_trip.node_max_mps2 < 2e-6);
    }

    #[test]
    fn a_holding_row_asks_for_no_torque_at_standstill_without_acceleration(accel in surfaces()) {
        let settings = InvertSettings { zero_row: ZeroRow::Hold, ..InvertSettings::default() };
        let map = invert(&file(&accel), table1(), &settings).unwrap().file.maps.remove(0);
        for (a, torque) in map.accel_mps2.iter().zip(&map.torque_nm[0]) {
            prop_assert!(*a > 0.0 || *torque == 0.0);
        }
    }

    #[test]
    fn files_survive_being_written_and_read(accel in surfaces()) {
        let file = file(&accel);
        prop_assert_eq!(Table1File::from_json(&file.to_json().unwrap()).unwrap(), file);
    }
}

#[test]
fn a_falling_surface_is_refused() {
    let mut accel = vec![vec![0.0; 12]; 8];
    for (i, row) in accel.iter_mut().enumerate() {
        row.fill(i as f64 * 0.1);
    }
    accel[4][3] = -2.0;
    let error = invert(&file(&accel), table1(), &InvertSettings::default()).unwrap_err();
    assert!(error.to_string().contains("does not rise with torque at 0.300 m/s"), "{error}");
}
