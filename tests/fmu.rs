//! The exported plant: the same torques give the speed of the simulator, by its C sources and as units of FMI 2.0 and 3.0 read by FMPy.
#![allow(clippy::unwrap_used)]

#[path = "common/compiled.rs"]
#[allow(dead_code)]
mod compiled;
#[path = "common/map_copy.rs"]
mod map_copy;
#[path = "common/readers.rs"]
mod readers;

use compiled::{answers, c_compiler};
use map_copy::{copied, run, text};
use pivot_cal::internals::{MotionSettings, World, WorldCommand, WorldSettings};
use pivot_cal::map::{Gear, Table1File};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Torque [N·m], gear and emergency stop of every millisecond: up, hold, coast, brake, reverse, less than breakaway, a stop on the way.
fn schedule() -> Vec<(f64, i32, bool)> {
    let stretches = [
        (0.0, 0, false, 100),
        (24.0, 1, false, 900),
        (40.0, 1, false, 700),
        (5.0, 1, false, 400),
        (-30.0, 1, false, 900),
        (0.0, 1, false, 300),
        (6.0, 1, false, 300),
        (-33.3, -1, false, 1100),
        (60.0, -1, false, 600),
        (0.0, 0, false, 200),
        (31.0, 1, false, 800),
        (31.0, 1, true, 700),
        (18.0, 1, false, 1000),
    ];
    stretches.iter().flat_map(|&(torque_nm, gear, estop, ms)| vec![(torque_nm, gear, estop); ms]).collect()
}

/// The plant of a map without anything random.
fn plant(maps: &Path) -> WorldSettings {
    let mut world = WorldSettings::identified(&Table1File::from_json(&text(maps, "table1.json")).unwrap()).unwrap();
    if let MotionSettings::Identified(motion) = &mut world.motion {
        (motion.disturbance_mps2, motion.run_offset_mps2) = (0.0, 0.0);
    }
    world
}

/// The same with factors on inertia, friction, lag and dead time.
fn perturbed(world: &WorldSettings, [inertia, friction, lag, dead_time]: [f64; 4]) -> WorldSettings {
    let mut world = world.clone();
    if let MotionSettings::Identified(motion) = &mut world.motion {
        motion.forward = motion.forward.perturbed(inertia, friction);
        motion.reverse = motion.reverse.as_ref().map(|surface| surface.perturbed(inertia, friction));
    }
    world.drive.lag_s *= lag;
    world.drive.dead_time_s *= dead_time;
    world
}

/// Speeds of the simulator [m/s] after every millisecond, and the headings [rad] with the wheel at 90°.
fn simulated(world: &WorldSettings, schedule: &[(f64, i32, bool)]) -> Vec<[f64; 2]> {
    let mut world = World::new(world, 1).unwrap();
    let angle = std::f64::consts::FRAC_PI_2;
    world.place_wheel(angle);
    let gears = [Some(Gear::Reverse), None, Some(Gear::Forward)];
    schedule
        .iter()
        .map(|&(torque_nm, gear, estop)| {
            world.set_estop(estop);
            world.step(&WorldCommand { torque_nm, wheel_angle_rad: angle, gear: gears[(gear + 1) as usize] });
            [world.state().speed_mps, world.state().heading_rad]
        })
        .collect()
}

/// The files of an archive without compression.
fn unpacked(path: &Path) -> BTreeMap<String, Vec<u8>> {
    let bytes = std::fs::read(path).unwrap();
    let number = |at: usize, size: usize| (0..size).fold(0, |sum, k| sum + (usize::from(bytes[at + k]) << (8 * k)));
    let (mut at, mut files) = (0, BTreeMap::new());
    while bytes[at..].starts_with(b"PK\x03\x04") {
        assert_eq!(number(at + 8, 2), 0, "stored, not compressed");
        let (size, name) = (number(at + 18, 4), number(at + 26, 2));
        let content = at + 30 + name + number(at + 28, 2);
        files.insert(String::from_utf8(bytes[at + 30..at + 30 + name].to_vec()).unwrap(), bytes[content..content + size].to_vec());
        at = content + size;
    }
    files
}

const HARNESS: &str = r#"
#include <stdio.h>
#include "pivot_plant.h"

static pivot_plant plant;

int main(void)
{
    double inertia, friction, lag, dead_time, torque, t_s = 0.0;
    int gear, stop;
    const char *why = "";
    pivot_plant_reset(&plant);
    if (scanf("%lf %lf %lf %lf", &inertia, &friction, &lag, &dead_time) != 4) {
        return 2;
    }
    plant.real[PLANT_INERTIA_FACTOR] = inertia;
    plant.real[PLANT_FRICTION_FACTOR] = friction;
    plant.real[PLANT_LAG_FACTOR] = lag;
    plant.real[PLANT_DEAD_TIME_FACTOR] = dead_time;
    if (pivot_plant_begin(&plant, 0.0, &why) != 0) {
        printf("refused: %s\n", why);
        return 0;
    }
    printf("begun\n");
    while (scanf("%lf %d %d", &torque, &gear, &stop) == 3) {
        plant.real[PLANT_TORQUE_NM] = torque;
        plant.integer[PLANT_GEAR] = gear;
        plant.integer[PLANT_EMERGENCY_STOP] = stop;
        t_s += 0.001;
        pivot_plant_advance(&plant, t_s);
        printf("%.17g %.17g\n", plant.real[PLANT_SPEED_MPS], plant.real[PLANT_HEADING_RAD]);
    }
    return 0;
}
"#;

#[test]
fn the_sources_give_the_speed_of_the_simulator_and_every_factor_acts_as_there() {
    let Some(compiler) = c_compiler() else { return readers::not_tested("the plant in C", "there is no C compiler") };
    let (folder, maps) = copied();
    let (status, said, errors) = run(folder.path(), &["export", "--format", "fmu", "--sources-only", "-o", "out"]);
    assert!(status == 0 && said.contains("sources only, no binary: left out, as asked"), "{said}{errors}");
    let files = unpacked(&folder.path().join("out/plant_fmi2.fmu"));
    for (name, content) in &files {
        if let Some(name) = name.strip_prefix("sources/") {
            std::fs::write(folder.path().join(name), content).unwrap();
        }
    }
    let program = compiled::c_program_of(&compiler, folder.path(), HARNESS, &["pivot_plant.c"], "-O2");
    let schedule = schedule();
    let lines = schedule.iter().fold(String::new(), |mut lines, (torque, gear, stop)| {
        writeln!(lines, "{torque:?} {gear} {}", i32::from(*stop)).unwrap();
        lines
    });
    let world = plant(&maps);
    let mut moved = Vec::new();
    for factors in [[1.0; 4], [1.4, 1.0, 1.0, 1.0], [1.0, 0.7, 1.0, 1.0], [1.0, 1.0, 2.0, 1.0], [1.0, 1.0, 1.0, 1.37]] {
        let [inertia, friction, lag, dead_time] = factors;
        let input = format!("{inertia:?} {friction:?} {lag:?} {dead_time:?}\n{lines}");
        let (begun, found) = answers(&program, &input, |line| {
            let numbers: Vec<f64> = line.split(' ').map(|n| n.parse().unwrap()).collect();
            [numbers[0], numbers[1]]
        });
        assert_eq!(begun, "begun");
        let expected = simulated(&perturbed(&world, factors), &schedule);
        assert_eq!(found.len(), expected.len());
        for part in [0, 1] {
            let worst = found.iter().zip(&expected).map(|(f, e)| (f[part] - e[part]).abs()).fold(0.0, f64::max);
            assert!(worst <= 1e-6, "{factors:?}: {worst} of part {part}");
        }
        assert!(expected.iter().any(|e| e[0] > 0.5) && expected.iter().any(|e| e[0] < -0.5));
        moved.push(expected.last().unwrap()[1]);
    }
    assert!(moved[1..].iter().all(|m| (m - moved[0]).abs() > 1e-3), "every factor changes the drive: {moved:?}");
    let (refused, _) = answers(&program, "1 200 1 1\n", |_| ());
    assert_eq!(refused, "refused: friction_factor is out of its range; allowed: 0.01 to 100.0");
}

#[test]
fn both_units_are_valid_and_simulate_packed_and_compiled_from_source_in_fmpy() {
    let Some(python) = readers::python(&["fmpy", "numpy", "lxml", "cmake"], "the FMUs in FMPy") else { return };
    if c_compiler().is_none() {
        return readers::not_tested("the FMUs in FMPy", "there is no C compiler");
    }
    let (folder, maps) = copied();
    let (status, said, errors) = run(folder.path(), &["export", "--format", "fmu", "-o", "packed"]);
    assert!(status == 0 && said.contains("binaries/"), "{said}{errors}");
    assert_eq!(run(folder.path(), &["export", "--format", "fmu", "--sources-only", "-o", "sources"]).0, 0);
    // an emergency stop is no part of these inputs
    let schedule: Vec<_> = schedule().into_iter().filter(|s| !s.2).collect();
    let task = serde_json::json!({
        "step_s": 0.001,
        "torque_nm": schedule.iter().map(|s| s.0).collect::<Vec<_>>(),
        "gear": schedule.iter().map(|s| s.1).collect::<Vec<_>>(),
    });
    let [packed, sources] = ["packed", "sources"].map(|name| folder.path().join(name));
    let answer = readers::read_with(&python, "fmu.py", &[&packed, &sources], &task.to_string());
    let world = plant(&maps);
    let column = |value: &Value, k: usize| -> Vec<f64> { value.as_array().unwrap().iter().map(|row| row[k].as_f64().unwrap()).collect() };
    let worst = |found: &[f64], expected: &[[f64; 2]]| {
        assert_eq!(found.len(), expected.len());
        found.iter().zip(expected).map(|(f, e)| (f - e[0]).abs()).fold(0.0, f64::max)
    };
    let (nominal, heavy) = (simulated(&world, &schedule), simulated(&perturbed(&world, [1.3, 0.8, 1.5, 1.2]), &schedule));
    for name in ["plant_fmi2.fmu", "plant_fmi3.fmu"] {
        let unit = &answer[name];
        assert_eq!(unit["problems"], serde_json::json!([]), "{name}");
        assert!(!unit["platforms"].as_array().unwrap().is_empty(), "{name} has a binary");
        for kind in ["binary", "compiled"] {
            let off = worst(&column(&unit[kind], 0), &nominal);
            assert!(off <= 1e-6, "{name}, {kind}: {off} m/s");
        }
        let off = worst(&column(&unit["heavy"], 0), &heavy);
        assert!(off <= 1e-6, "{name}, perturbed: {off} m/s");
        // the sensor reads every 20 ms and late; with noise the plant drives otherwise
        let readings = column(&unit["binary"], 1);
        let changes = readings.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(changes > 100 && changes * 15 < readings.len(), "{changes} readings in {} ms", readings.len());
        let off = worst(&column(&unit["noisy"], 0), &nominal);
        assert!(off > 1e-3 && off < 0.5, "{name}, with noise: {off} m/s");
        let restored = column(&serde_json::json!([unit["restored"]]), 0)[0];
        assert!(
            restored > 0.05 && unit["restored"].as_array().unwrap().iter().all(|v| v.as_f64().unwrap() == restored),
            "{}",
            unit["restored"]
        );
    }
}

#[test]
fn without_a_compiler_the_sources_are_written_and_it_says_so() {
    let (folder, _) = copied();
    let mut command = assert_cmd::Command::cargo_bin("pivot-cal").unwrap();
    let output =
        command.current_dir(folder.path()).env("PATH", folder.path()).args(["export", "--format", "fmu", "-o", "out"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("sources only, no binary: there is no C compiler cc on the path"), "{said}");
    for name in ["plant_fmi2.fmu", "plant_fmi3.fmu"] {
        let files = unpacked(&folder.path().join("out").join(name));
        assert!(files.contains_key("modelDescription.xml") && files.contains_key("sources/pivot_plant.c"));
        assert!(files.keys().all(|name| !name.starts_with("binaries/")), "{name}");
    }
}
