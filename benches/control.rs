//! What the controller costs: a look-up, a control period, a whole pivot simulated (with its ratio to real time), a verdict.

use pivot_cal::control::{
    Inputs, OutsidePolicy, PivotController, PivotSettings as Control, Pose, Tables, TorqueFromAccel, WaypointLaw, WaypointLawSettings,
};
use pivot_cal::internals::{PhysicalSettings, WorldSettings as World, known_maps, replay};
use pivot_cal::map::{Gear, TorqueTable, Vehicle};
use pivot_cal::verify::{Maps, Scenario, VerifySettings};
use std::hint::black_box;

fn main() {
    divan::main();
}

fn maps() -> Maps {
    let vehicle =
        Vehicle { wheelbase_m: 0.92, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: Some(44.0), torque_full_scale_nm: None };
    let (table1, table2) = known_maps(&World::physical(vehicle, PhysicalSettings::default())).expect("the default vehicle is sound");
    Maps::new(table1, table2).expect("both gears are there")
}

/// One look-up in a table of 21 × 58.
#[divan::bench]
fn look_up(bencher: divan::Bencher<'_, '_>) {
    let maps = maps();
    let tables =
        Tables { forward: maps.forward.view(), reverse: maps.reverse.as_ref().map(TorqueTable::view), policy: OutsidePolicy::Clamp };
    bencher.bench_local(|| tables.torque(Gear::Forward, black_box(0.333), black_box(0.217)));
}

/// One control period while driving.
#[divan::bench]
fn control_period(bencher: divan::Bencher<'_, '_>) {
    let maps = maps();
    let tables =
        Tables { forward: maps.forward.view(), reverse: maps.reverse.as_ref().map(TorqueTable::view), policy: OutsidePolicy::Clamp };
    let settings = Control::new(0.92, std::f64::consts::FRAC_PI_2);
    let law = WaypointLaw::new(WaypointLawSettings::new(0.92), tables);
    let mut controller = PivotController::new(&settings, law).expect("the defaults are sound");
    controller.request(1.5, Pose::default()).expect("a turn of 1.5 rad can be planned");
    let mut inputs = Inputs {
        speed_mps: Some(0.0),
        wheel_angle_rad: std::f64::consts::FRAC_PI_2,
        pose: Pose::default(),
        gear: Some(Gear::Forward),
        estop: false,
    };
    for _ in 0..20 {
        controller.step(&inputs);
    }
    inputs.speed_mps = Some(0.3);
    bencher.bench_local(|| controller.step(black_box(&inputs)));
}

/// A turn of 90° with steering out and back, all sensors and the controller: 7.4 s of the vehicle's time, so that 0.74 ms are 10,000 × real
/// time.
#[divan::bench]
fn pivot_simulated(bencher: divan::Bencher<'_, '_>) {
    let maps = maps();
    let settings = VerifySettings::new().expect("the built-in gate is sound");
    let scenario = Scenario::all().into_iter().find(|s| s.name == "left-90").expect("it is there");
    bencher.bench_local(|| replay(&maps, &settings, &scenario, |_| {}));
}
