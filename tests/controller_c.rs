//! The exported controller, compiled as a vehicle would compile it, side by side with the one that was verified: every scenario, nominal and with
//! other controller files, compared bit by bit.
#![allow(clippy::unwrap_used)]

#[path = "common/compiled.rs"]
#[allow(dead_code)]
mod compiled;
#[path = "common/map_copy.rs"]
mod map_copy;
#[path = "common/readers.rs"]
mod readers;

use compiled::{answers, c_compiler, c_program_of};
use map_copy::{copied, run, text};
use pivot_cal::control::{Failure, Gear, Outputs, Phase, SteeringFault, WheelPolicy};
use pivot_cal::controller::ControllerFile;
use pivot_cal::internals::{PivotMoment, replay};
use pivot_cal::verify::{Maps, Scenario, VerifySettings};
use std::fmt::Write as _;
use std::path::Path;

/// Lines `i policy right return` (start), `r turn x y heading` (request) and `s has_speed speed angle x y heading gear stop` (step), reals as bit
/// patterns; answers a line for each.
const HARNESS: &str = r#"
#include "pivot_controller.h"
#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static double real(void)
{
    uint64_t bits;
    double number;
    if (scanf("%" SCNx64, &bits) != 1) {
        return 0.0;
    }
    memcpy(&number, &bits, sizeof number);
    return number;
}

static void show(double number)
{
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    printf(" %" PRIx64, bits);
}

int main(void)
{
    static pivot_controller controller;
    char kind;
    printf("%d\n", PIVOT_CONTROLLER_VERIFIED);
    while (scanf(" %c", &kind) == 1) {
        if (kind == 'i') {
            pivot_presets presets = pivot_controller_presets;
            int policy;
            if (scanf("%d", &policy) != 1) {
                return 2;
            }
            presets.policy = (pivot_policy)policy;
            presets.right_angle_rad = real();
            presets.return_angle_rad = real();
            printf("%d\n", (int)pivot_controller_init(&controller, &presets));
        } else if (kind == 'd') {
            printf("%d", (int)pivot_controller_presets.policy);
            show(pivot_controller_presets.right_angle_rad);
            show(pivot_controller_presets.return_angle_rad);
            printf("\n");
        } else if (kind == 'r') {
            const double turn = real();
            pivot_pose pose;
            pose.x_m = real();
            pose.y_m = real();
            pose.heading_rad = real();
            printf("%d\n", (int)pivot_controller_request(&controller, turn, &pose));
        } else {
            pivot_inputs in;
            pivot_outputs out;
            int gear;
            if (scanf("%d", &in.has_speed) != 1) {
                return 2;
            }
            in.speed_mps = real();
            in.wheel_angle_rad = real();
            in.pose.x_m = real();
            in.pose.y_m = real();
            in.pose.heading_rad = real();
            if (scanf("%d %d", &gear, &in.emergency_stop) != 2) {
                return 2;
            }
            in.gear = (pivot_gear)gear;
            pivot_controller_step(&controller, &in, &out);
            printf("%d %d %d %d %d %d %d %d", (int)out.gear, (int)out.phase, (int)out.failure, out.restore, out.has_drive, out.limited,
                   out.outside_table, out.end_reached);
            show(out.torque_nm);
            show(out.wheel_angle_rad);
            show(out.target_speed_mps);
            show(out.drive_speed_mps);
            show(out.accel_mps2);
            show(out.arc_m);
            printf("\n");
        }
    }
    return 0;
}
"#;

fn gear_number(gear: Option<Gear>) -> i32 {
    match gear {
        None => 0,
        Some(Gear::Forward) => 1,
        Some(Gear::Reverse) => -1,
    }
}

fn phase_numbers(phase: Phase) -> [i32; 2] {
    match phase {
        Phase::Idle => [0, 0],
        Phase::WaitingForAngle => [1, 0],
        Phase::SettingGear => [2, 0],
        Phase::Driving => [3, 0],
        Phase::WaitingForStandstill => [4, 0],
        Phase::RestoringAngle => [5, 0],
        Phase::Succeeded => [6, 0],
        Phase::Failed(failure) => [
            7,
            match failure {
                Failure::ObstacleStop => 1,
                Failure::Steering(SteeringFault::Implausible) => 2,
                Failure::Steering(SteeringFault::Stuck) => 3,
                Failure::Steering(SteeringFault::TooSlow) => 4,
                Failure::Steering(SteeringFault::Lost) => 5,
                Failure::GearNotSet => 6,
                Failure::SpeedLost => 7,
                Failure::StoodStill => 8,
                Failure::TimeOut => 9,
                Failure::OutsideTable => 10,
            },
        ],
    }
}

/// The line that the harness must answer with for the commands of a period.
fn line(command: &Outputs) -> String {
    let [phase, failure] = phase_numbers(command.phase);
    let drive = command.drive.unwrap_or_default();
    let flags = [command.restore, command.drive.is_some(), drive.limited, drive.outside_table, drive.end_reached].map(i32::from);
    let mut line = format!("{} {phase} {failure}", gear_number(command.gear));
    for flag in flags {
        write!(line, " {flag}").unwrap();
    }
    let reals = [command.torque_nm, command.wheel_angle_rad, drive.target_speed_mps, drive.speed_mps, drive.accel_mps2, drive.arc_m];
    line + &bits(&reals)
}

fn bits(reals: &[f64]) -> String {
    reals.iter().fold(String::new(), |line, real| format!("{line} {:x}", real.to_bits()))
}

/// The input lines and expected answers of a scenario as the verdict drives it, and whether every kind of end was there.
struct Course {
    input: String,
    expected: Vec<String>,
}

impl Course {
    fn add(&mut self, scenario: &Scenario, moments: &[PivotMoment], presets: [f64; 2]) {
        let right = scenario.right_wheel_deg.map_or(presets[0], |deg| deg * pivot_cal::control::RAD_PER_DEG);
        let back = scenario.return_wheel_deg.map_or(presets[1], |deg| deg * pivot_cal::control::RAD_PER_DEG);
        let policy = i32::from(scenario.policy == WheelPolicy::Mirror);
        writeln!(self.input, "i {policy}{}", bits(&[right, back])).unwrap();
        self.expected.push("0".to_owned());
        let (mut before, mut turns) = (Phase::Idle, scenario.turns_deg.iter());
        for moment in moments {
            let (seen, phase) = (&moment.seen, moment.command.phase);
            let pose = [seen.x_m, seen.y_m, seen.heading_rad];
            // a turn begins when the phase leaves one without a turn
            if !before.is_active() && phase != before {
                let turn_rad = turns.next().unwrap() * pivot_cal::control::RAD_PER_DEG;
                writeln!(self.input, "r{}", bits(&[&[turn_rad], &pose[..]].concat())).unwrap();
                self.expected.push("0".to_owned());
            }
            before = phase;
            let reals = bits(&[&[seen.speed_mps.unwrap_or(0.0), seen.wheel_angle_rad], &pose[..]].concat());
            let (has_speed, stop) = (i32::from(seen.speed_mps.is_some()), i32::from(seen.estop));
            writeln!(self.input, "s {has_speed}{reals} {} {stop}", gear_number(seen.gear)).unwrap();
            self.expected.push(line(&moment.command));
        }
    }
}

/// Exports the controller of the folder's map and builds it with the harness.
fn built(compiler: &Path, folder: &Path, optimise: &str) -> std::path::PathBuf {
    let (status, said, errors) = run(folder, &["export", "--format", "controller-c", "--unverified", "-o", "out"]);
    assert_eq!(status, 0, "{said}{errors}");
    c_program_of(compiler, &folder.join("out"), HARNESS, &["pivot_controller.c", "pivot_controller_library.c"], optimise)
}

#[test]
fn every_scenario_gives_the_verified_commands_bit_by_bit_with_every_controller_file() {
    let Some(compiler) = c_compiler() else { return readers::not_tested("the controller in C", "there is no C compiler") };
    let slow = "name = \"other\"\nperiod_s = 0.01\n[planning]\nwheel_policy = \"mirror\"\nright_angle_deg = -85\nreturn_angle_deg = 10\n\
                [preview]\nnearest = \"waypoint\"\n[finish]\noutside_axes = \"refuse\"\n[additions]\ntorque_rate_nm_s = 300\nreaction_s = 0.13\n\
                [monitoring]\nfailure_decel_mps2 = \"coast\"\n";
    let own = text(Path::new(env!("CARGO_MANIFEST_DIR")), "data/controllers/default.toml");
    let plain = text(Path::new(env!("CARGO_MANIFEST_DIR")), "data/controllers/plain.toml");
    let mut ends = std::collections::BTreeSet::new();
    for (name, file) in [("default", own.as_str()), ("plain", &plain), ("other", slow)] {
        let (folder, maps) = copied();
        std::fs::write(folder.path().join("controller.toml"), file).unwrap();
        // the verdict of the folder names the settings that the export compiles in
        run(folder.path(), &["verify", "--controller-settings", "controller.toml", "--scenario", "left-90", "--draws", "1", "--fresh"]);
        let program = built(&compiler, folder.path(), "-O2");
        let read = Maps::read(&maps, false).unwrap();
        let mut settings = VerifySettings::new().unwrap();
        settings.controller = ControllerFile::from_toml(file).unwrap();
        let (_, presets) = answers(&program, "d\n", |line| {
            line.split(' ').skip(1).map(|word| f64::from_bits(u64::from_str_radix(word, 16).unwrap())).collect::<Vec<_>>()
        });
        let presets = [presets[0][0], presets[0][1]];
        let mut course = Course { input: String::new(), expected: Vec::new() };
        for scenario in Scenario::all() {
            for seed in 1..=2 {
                settings.seed = seed;
                let mut moments = Vec::new();
                if replay(&read, &settings, &scenario, |moment| moments.push(*moment)).is_ok() {
                    course.add(&scenario, &moments, presets);
                    ends.extend(moments.last().map(|m| format!("{:?}", m.command.phase)));
                }
            }
        }
        let (_, found) = answers(&program, &course.input, str::to_owned);
        assert_eq!(found.len(), course.expected.len());
        assert!(found.len() > 20_000, "{} answers", found.len());
        if let Some(k) = (0..found.len()).find(|&k| found[k] != course.expected[k]) {
            panic!("{name}: answer {k}: {} instead of {}, asked {}", found[k], course.expected[k], course.input.lines().nth(k).unwrap());
        }
    }
    // not only successes are compared
    for end in ["Succeeded", "Failed(ObstacleStop)", "Failed(SpeedLost)", "Failed(Steering(Stuck))", "Failed(Steering(Implausible))"] {
        assert!(ends.contains(end), "{end} is not among {ends:?}");
    }
}

#[test]
fn requests_and_readings_that_are_no_numbers_are_answered_as_by_the_library() {
    use pivot_cal::control::{Inputs, PivotController, PivotSettings, Pose, WaypointLaw, WaypointLawSettings};
    let Some(compiler) = c_compiler() else { return readers::not_tested("the controller in C", "there is no C compiler") };
    let (folder, maps) = copied();
    let program = built(&compiler, folder.path(), "-O0");
    let read = Maps::read(&maps, false).unwrap();
    let vehicle = read.table2.vehicle;
    let tables = pivot_cal::control::Tables {
        forward: read.forward.view(),
        reverse: read.reverse.as_ref().map(pivot_cal::map::TorqueTable::view),
        policy: pivot_cal::control::OutsidePolicy::Clamp,
    };
    let settings = PivotSettings::new(vehicle.wheelbase_m, vehicle.test_angle().rad());
    let law =
        WaypointLawSettings { reaction_s: read.table2.dead_time_s + read.table2.lag_s, ..WaypointLawSettings::new(vehicle.wheelbase_m) };
    let mut controller = PivotController::new(&settings, WaypointLaw::new(law, tables)).unwrap();
    let mut course = Course { input: format!("i 0{}\n", bits(&[settings.planning.right_angle_rad, 0.0])), expected: vec!["0".to_owned()] };
    let mut request = |controller: &mut PivotController<_>, turn_rad: f64, pose: Pose, answer: i32| {
        assert_eq!(controller.request(turn_rad, pose).is_ok(), answer == 0, "{turn_rad} {pose:?}");
        writeln!(course.input, "r{}", bits(&[turn_rad, pose.x_m, pose.y_m, pose.heading_rad])).unwrap();
        course.expected.push(answer.to_string());
    };
    let at = |heading_rad: f64| Pose { x_m: 1.0, y_m: -2.0, heading_rad };
    request(&mut controller, f64::NAN, at(0.0), 3);
    request(&mut controller, 0.001, at(0.0), 3);
    request(&mut controller, 7.0, at(0.0), 3);
    request(&mut controller, 1.0, at(f64::INFINITY), 2);
    request(&mut controller, -1.0, at(-12345.678), 0);
    request(&mut controller, 1.0, at(0.0), 1);
    // a walk through every phase with readings that are wrong now and then; the headings cross every branch of sine and cosine
    let mut number = 88_172_645_463_325_252_u64;
    let mut random = move || {
        number ^= number << 13;
        number ^= number >> 7;
        number ^= number << 17;
        number as f64 / u64::MAX as f64
    };
    let mut wheel_rad = 0.0;
    for k in 0..30_000 {
        if k % 700 == 699 && !controller.phase().is_active() {
            let (turn_rad, pose) = (6.2 * (2.0 * random() - 1.0), at(40.0 * (random() - 0.5)));
            if controller.request(turn_rad, pose).is_ok() {
                writeln!(course.input, "r{}", bits(&[turn_rad, pose.x_m, pose.y_m, pose.heading_rad])).unwrap();
                course.expected.push("0".to_owned());
            }
        }
        let odd = random();
        let speed_mps = match odd {
            _ if odd < 0.001 => Some(f64::NAN),
            _ if odd < 0.002 => Some(1e300),
            _ if odd < 0.05 => None,
            _ => Some(0.8 * random() - 0.2),
        };
        let heading_rad = if odd > 0.999 { f64::NAN } else { 40.0 * (random() - 0.5) };
        let inputs = Inputs {
            speed_mps,
            wheel_angle_rad: if odd > 0.998 && odd < 0.999 { 3.0 } else { wheel_rad },
            pose: Pose { x_m: random(), y_m: random(), heading_rad },
            gear: controller.current().map(|request| request.gear),
            estop: odd > 0.9975 && odd < 0.998,
        };
        let command = controller.step(&inputs);
        wheel_rad += (command.wheel_angle_rad - wheel_rad).clamp(-0.1, 0.1);
        let reals =
            bits(&[inputs.speed_mps.unwrap_or(0.0), inputs.wheel_angle_rad, inputs.pose.x_m, inputs.pose.y_m, inputs.pose.heading_rad]);
        let stop = i32::from(inputs.estop);
        writeln!(course.input, "s {}{reals} {} {stop}", i32::from(inputs.speed_mps.is_some()), gear_number(inputs.gear)).unwrap();
        course.expected.push(line(&command));
    }
    let (_, found) = answers(&program, &course.input, str::to_owned);
    assert_eq!(found.len(), course.expected.len());
    let driving = found.iter().filter(|line| line.split(' ').nth(1) == Some("3")).count();
    assert!(driving > 300, "{driving} periods of driving");
    for (k, (found, expected)) in found.iter().zip(&course.expected).enumerate() {
        assert_eq!(found, expected, "answer {k}, asked {}", course.input.lines().nth(k).unwrap());
    }
}

#[test]
fn single_precision_and_whole_counts_are_refused_since_they_were_not_verified() {
    let (folder, _) = copied();
    for flag in ["--float", "--int16"] {
        let (status, _, errors) = run(folder.path(), &["export", "--format", "controller-c", flag]);
        assert!(status == 1 && errors.contains("controller-c computes in double precision, as it was verified"), "{errors}");
    }
    let (status, _, errors) = run(folder.path(), &["export", "--format", "controller-c", "--speed-unit", "km/h"]);
    assert!(status == 1 && errors.contains("controller-c has units of its own"), "{errors}");
}

/// The verdict's scenarios, without what is said about them in words.
fn figures(maps: &Path) -> Vec<(String, String, String)> {
    let verdict: serde_json::Value = serde_json::from_str(&text(maps, "verify.json")).unwrap();
    let scenarios = verdict["scenarios"].as_array().unwrap().iter();
    scenarios.map(|s| (s["name"].to_string(), s["status"].to_string(), s["metrics"].to_string())).collect()
}

/// The shared library of C sources in `folder`.
fn library(compiler: &Path, folder: &Path, sources: &[&str], name: &str) {
    let mut command = std::process::Command::new(compiler);
    command.current_dir(folder).args(["-std=c99", "-O2", "-fPIC", "-shared", "-ffp-contract=off", "-o", name]).args(sources).arg("-lm");
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_library_of_the_template_gets_the_verdict_of_the_bundled_controller_on_every_draw() {
    let Some(compiler) = c_compiler() else { return readers::not_tested("the controller as a library", "there is no C compiler") };
    let (folder, maps) = copied();
    let out = folder.path().join("out");
    assert_eq!(run(folder.path(), &["export", "--format", "controller-c", "-o", "out"]).0, 0);
    library(&compiler, &out, &["pivot_controller.c", "pivot_controller_library.c"], "../law.so");
    let all = ["--draws", "6", "--fresh"];
    let (bundled, ..) = run(folder.path(), &[&["verify"], &all[..]].concat());
    let expected = figures(&maps);
    let (status, said, errors) = run(folder.path(), &[&["verify", "--controller", "law.so"], &all[..]].concat());
    assert_eq!(status, bundled, "{said}{errors}");
    assert!(said.contains("controller: the library `law.so`"), "{said}");
    assert_eq!(figures(&maps), expected);
    assert!(expected.len() > 15);
    let verdict: serde_json::Value = serde_json::from_str(&text(&maps, "verify.json")).unwrap();
    let bytes = std::fs::read(folder.path().join("law.so")).unwrap();
    assert_eq!(verdict["controller_command"]["sha256"], pivot_cal::map::sha256_hex(&bytes));
    // a verdict on a library is none on the map with the bundled controller
    let (status, _, errors) = run(folder.path(), &["export", "--format", "c"]);
    assert!(status == 3 && errors.contains("the verdict is about the library `law.so`"), "{errors}");
}

#[test]
fn a_library_that_is_none_or_answers_nonsense_is_named_with_what_is_wrong() {
    let Some(compiler) = c_compiler() else { return readers::not_tested("broken libraries", "there is no C compiler") };
    let (folder, maps) = copied();
    let out = folder.path().join("out");
    assert_eq!(run(folder.path(), &["export", "--format", "controller-c", "-o", "out"]).0, 0);
    let template = text(&out, "pivot_controller_library.c");
    let one = |broken: &str, name: &str| {
        std::fs::write(out.join("broken.c"), broken).unwrap();
        library(&compiler, &out, &["pivot_controller.c", "broken.c"], &format!("../{name}"));
        run(
            folder.path(),
            &["verify", "--controller", name, "--scenario", "left-90", "--draws", "1", "--controller-timeout-ms", "200", "--fresh"],
        )
    };
    let (status, _, errors) = run(folder.path(), &["verify", "--controller", "absent.so"]);
    assert!(status == 1 && errors.contains("absent.so cannot be started"), "{errors}");
    std::fs::write(folder.path().join("text.so"), "no library").unwrap();
    let (status, _, errors) = run(folder.path(), &["verify", "--controller", "text.so"]);
    assert!(status == 1 && errors.contains("text.so is no controller") && errors.contains("pivot_controller_library.c"), "{errors}");
    let (status, _, errors) = one(&template.replace("return 1u << 24", "return 2u << 24"), "old.so");
    assert!(status == 1 && errors.contains("old.so is no controller: it is built for version 0x2"), "{errors}");
    let (status, _, errors) = one(&template.replace("pivot_library_step", "pivot_library_steps"), "lacks.so");
    assert!(status == 1 && errors.contains("pivot_library_step"), "{errors}");
    let step = "pivot_controller_step((pivot_controller *)controller, inputs, outputs);\n";
    assert!(template.contains(step));
    for (change, name, fault) in [
        ("outputs->torque_nm = outputs->phase == PIVOT_DRIVING ? 0.0 / 0.0 : 0.0;", "nan.so", "torque_nm is NaN; allowed"),
        (
            "if (outputs->phase == PIVOT_DRIVING) { outputs->phase = (pivot_phase)42; }",
            "phase.so",
            "the phase is number 42; allowed: 0 to 7",
        ),
        (
            "if (outputs->phase == PIVOT_DRIVING) { outputs->gear = (pivot_gear)2; }",
            "gear.so",
            "the gear is number 2; allowed: 1, 0 and -1",
        ),
        ("if (outputs->phase == PIVOT_DRIVING) { volatile double x = 0.0; while (x < 4e8) { x += 1.0; } }", "late.so", "allowed: 200 ms"),
    ] {
        let (status, said, errors) = one(&template.replace(step, &format!("{step}    {change}\n")), name);
        assert_eq!(status, 3, "{name}: {said}{errors}");
        let verdict: serde_json::Value = serde_json::from_str(&text(&maps, "verify.json")).unwrap();
        let notes = verdict["scenarios"][0]["notes"].to_string();
        assert!(notes.contains("the controller broke: nominal run, at ") && notes.contains(fault), "{name}: {notes}");
    }
}
