//! How fast the simulator runs: one iteration is one simulated second, with all sensors and a controller that reads them at 50 Hz, so that
//! the items per second are the factor over real time.

use divan::counter::ItemsCount;
use pivot_cal::internals::{GearSurface, IdentifiedSettings, MotionSettings, PhysicalSettings, Truth, World, WorldCommand, WorldSettings};
use pivot_cal::map::{AccelTable, Axis, Gear, Vehicle};
use std::f64::consts::FRAC_PI_2;

fn main() {
    divan::main();
}

fn physical() -> WorldSettings {
    let vehicle =
        Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };
    let motion = PhysicalSettings { friction_spread: 0.01, disturbance_nm: 0.25, ..PhysicalSettings::default() };
    WorldSettings::physical(vehicle, motion)
}

/// The physical plant's map on a grid of 101 × 81, as a fit writes it.
fn identified() -> WorldSettings {
    let settings = physical();
    let truth = Truth::new(&PhysicalSettings::default(), &settings.vehicle).expect("default settings are sound");
    let direction = |gear| {
        let speed = Axis::uniform("speed", 0.0, 0.015, 1.5).expect("increasing");
        let torque = Axis::uniform("torque", -40.0, 1.0, 40.0).expect("increasing");
        let accel = |u: f64, v: f64| truth.gear_accel_mps2(gear, v, u, FRAC_PI_2);
        let values = torque.breaks().iter().flat_map(|&u| speed.breaks().iter().map(move |&v| accel(u, v))).collect();
        let table = AccelTable::new(speed, torque, values).expect("one value per cell");
        GearSurface { table, breakaway_nm: truth.breakaway_nm(gear, FRAC_PI_2) }
    };
    let motion = IdentifiedSettings {
        forward: direction(Gear::Forward),
        reverse: Some(direction(Gear::Reverse)),
        power_limit_nm_mps: f64::INFINITY,
        disturbance_mps2: 0.03,
        disturbance_time_s: 0.2,
        run_offset_mps2: 0.02,
        slope_share: 0.5,
        wheel_mass_kg: 6.0,
    };
    WorldSettings { motion: MotionSettings::Identified(Box::new(motion)), ..settings }
}

/// One simulated second of pivoting at about 0.6 m/s.
fn second(world: &mut World) {
    for _ in 0..50 {
        let seen = world.measure();
        let torque_nm = 11.0 + 40.0 * (0.6 - seen.speed_mps.unwrap_or(0.0));
        let command = WorldCommand { torque_nm, wheel_angle_rad: FRAC_PI_2, gear: Some(Gear::Forward) };
        for _ in 0..20 {
            world.step(&command);
        }
    }
}

fn bench(bencher: divan::Bencher<'_, '_>, settings: &WorldSettings) {
    let mut world = World::new(settings, 1).expect("sound settings");
    world.place_wheel(FRAC_PI_2);
    bencher.counter(ItemsCount::new(1_u32)).bench_local(|| {
        second(&mut world);
        world.state().speed_mps
    });
}

#[divan::bench]
fn physical_plant(bencher: divan::Bencher<'_, '_>) {
    bench(bencher, &physical());
}

#[divan::bench]
fn identified_plant(bencher: divan::Bencher<'_, '_>) {
    bench(bencher, &identified());
}

#[divan::bench]
fn new_world(bencher: divan::Bencher<'_, '_>) {
    let settings = identified();
    bencher.bench_local(|| World::new(&settings, 1));
}
