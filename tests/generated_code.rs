//! The exported C and Rust, compiled as a controller would compile them, against the library: dense places, every edge with its
//! neighbours, and inputs that are no numbers.
#![allow(clippy::unwrap_used)]

#[path = "common/compiled.rs"]
mod compiled;
#[path = "common/map_copy.rs"]
mod map_copy;
#[path = "common/readers.rs"]
mod readers;

use map_copy::{change_table2, copied, run, text};
use pivot_cal::control::lookup;
use pivot_cal::map::{Gear, Table2File, TorqueTable};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Reads lines `gear speed accel` of bit patterns; prints, for both look-ups, `status bits`.
const C_HARNESS: &str = r#"
#include "pivot_map.h"
#include <inttypes.h>
#include <stdio.h>
typedef union { pivot_map_real number; BITS_TYPE bits; } word;
int main(void)
{
    int gear;
    word speed, accel, torque;
    printf("%d\n", pivot_map_self_test());
    while (scanf("%d %" SCNx64_OR_32 " %" SCNx64_OR_32, &gear, &speed.bits, &accel.bits) == 3) {
        pivot_map_status status = pivot_map_torque((pivot_map_gear)gear, speed.number, accel.number, &torque.number);
        printf("%d %" PRIx64_OR_32 " ", (int)status, torque.bits);
        status = pivot_map_torque_clamped((pivot_map_gear)gear, speed.number, accel.number, &torque.number);
        printf("%d %" PRIx64_OR_32 "\n", (int)status, torque.bits);
    }
    return 0;
}
"#;

const RUST_HARNESS: &str = r#"
#![no_std]
extern crate std;
mod pivot_map;
use pivot_map::{Gear, Real};
use std::io::BufRead;
use std::println;
fn main() {
    println!("{}", i32::from(pivot_map::self_test()));
    for line in std::io::stdin().lock().lines() {
        let line = line.unwrap();
        let mut words = line.split(' ');
        let gear = if words.next() == Some("0") { Gear::Forward } else { Gear::Reverse };
        let mut number = || Real::from_bits(BITS::from_str_radix(words.next().unwrap(), 16).unwrap());
        let (speed, accel) = (number(), number());
        let inside = pivot_map::torque(gear, speed, accel);
        let clamped = pivot_map::torque_clamped(gear, speed, accel);
        let status = |outside: bool| if outside { 1 } else { 0 };
        println!(
            "{} {:x} {} {:x}",
            match (inside, clamped) { (Some(_), _) => 0, (None, Some(_)) => 1, _ => 2 },
            inside.unwrap_or(0.0).to_bits(),
            clamped.map_or(2, |c| status(c.outside)),
            clamped.map_or(0.0, |c| c.torque_nm).to_bits()
        );
    }
}
"#;

/// One answer: status and torque of the look-up that refuses, and of the one that clamps.
#[derive(Debug, PartialEq)]
struct Answer(i32, u64, i32, u64);

fn compiler() -> Option<PathBuf> {
    let found = compiled::c_compiler();
    if found.is_none() {
        readers::not_tested("C export", "there is no C compiler");
    }
    found
}

fn c_program(compiler: &Path, folder: &Path, bits: u32, optimise: &str) -> PathBuf {
    let harness = C_HARNESS.replace("BITS_TYPE", &format!("uint{bits}_t")).replace("64_OR_32", &bits.to_string());
    compiled::c_program(compiler, folder, &harness, "pivot_map.c", optimise)
}

fn rust_program(folder: &Path, bits: u32) -> PathBuf {
    compiled::rust_program(folder, &RUST_HARNESS.replace("BITS", &format!("u{bits}")))
}

/// Runs a harness: the result of its self-test, and its answers.
fn answers(program: &Path, input: &str) -> (String, Vec<Answer>) {
    compiled::answers(program, input, |line| {
        let words: Vec<_> = line.split(' ').collect();
        let bits = |k: usize| u64::from_str_radix(words[k], 16).unwrap();
        Answer(words[0].parse().unwrap(), bits(1), words[2].parse().unwrap(), bits(3))
    })
}

/// Breaks, their neighbours, places between, beyond, and awkward numbers.
fn places(breaks: &[f64]) -> Vec<f64> {
    let mut places: Vec<f64> = breaks.iter().flat_map(|b| [*b, b.next_up(), b.next_down()]).collect();
    places.extend(breaks.windows(2).flat_map(|w| [0.25, 0.5, 0.8137].map(|p| w[0] + p * (w[1] - w[0]))));
    let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
    places.extend([first - 1.0, last + 1.0, -0.0, f64::MIN_POSITIVE, 5e-324, -1e-300, 1e300, -1e300, f64::MAX]);
    places.extend([f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -f64::NAN]);
    places
}

fn tables(maps: &Path) -> Vec<(Gear, TorqueTable)> {
    let file = Table2File::from_json(&text(maps, "table2.json")).unwrap();
    file.maps.iter().map(|map| (map.gear, map.table().unwrap())).collect()
}

/// What the library answers.
fn expected(table: Option<&TorqueTable>, speed: f64, accel: f64) -> Answer {
    let Some(table) = table else { return Answer(3, 0, 3, 0) };
    let zero = 0f64.to_bits();
    match (table.torque_from_accel(speed, accel), table.torque_from_accel_clamped(speed, accel)) {
        (Some(inside), Some(clamped)) => Answer(0, inside.to_bits(), 0, clamped.to_bits()),
        (None, Some(clamped)) => Answer(1, zero, 1, clamped.to_bits()),
        _ => Answer(2, zero, 2, zero),
    }
}

/// Every place of both gears: the input of a harness in double precision, and the library's answers.
fn dense(tables: &[(Gear, TorqueTable)]) -> (String, Vec<Answer>) {
    let (mut input, mut answers) = (String::new(), Vec::new());
    for gear in Gear::ALL {
        let table = tables.iter().find(|t| t.0 == gear).map(|t| &t.1);
        let axes = &tables[0].1;
        for speed in places(axes.speed_mps().breaks()) {
            for accel in places(axes.accel_mps2().breaks()) {
                writeln!(input, "{} {:x} {:x}", i32::from(gear == Gear::Reverse), speed.to_bits(), accel.to_bits()).unwrap();
                answers.push(expected(table, speed, accel));
            }
        }
    }
    (input, answers)
}

#[track_caller]
fn expect_same(input: &str, found: &[Answer], wanted: &[Answer]) {
    assert_eq!(found.len(), wanted.len());
    for ((line, found), wanted) in input.lines().zip(found).zip(wanted) {
        assert_eq!(found, wanted, "at {line}");
    }
}

#[test]
fn c_in_double_precision_is_the_library_bit_for_bit() {
    let Some(compiler) = compiler() else { return };
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "c"]).0, 0);
    let (input, wanted) = dense(&tables(&maps));
    assert!(wanted.len() > 50_000);
    for optimise in ["-O0", "-O2"] {
        let program = c_program(&compiler, &maps.join("export"), 64, optimise);
        let (self_test, found) = answers(&program, &input);
        assert_eq!(self_test, "1", "the tables are sound");
        expect_same(&input, &found, &wanted);
    }
}

#[test]
fn rust_in_double_precision_is_the_library_bit_for_bit() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "rust", "--double"]).0, 0);
    let (input, wanted) = dense(&tables(&maps));
    let (self_test, found) = answers(&rust_program(&maps.join("export"), 64), &input);
    assert_eq!(self_test, "1");
    expect_same(&input, &found, &wanted);
}

/// Places and answers in single precision. The look-up's errors in half units in the last place (2⁻²⁴): at most 16 of the largest torque
/// (the table's rounding and that of seven operations on each of two levels), and, since a break is rounded, two of the largest break
/// times the steepest slope, per axis.
fn expect_float(programs: &[PathBuf], maps: &Path) {
    let half_ulp = 2f64.powi(-24);
    for (gear, table) in tables(maps) {
        let (speeds, accels) = (table.speed_mps().breaks(), table.accel_mps2().breaks());
        let slope = |breaks: &[f64], value: &dyn Fn(usize, usize) -> f64, lines: usize| {
            let steps = (0..lines).flat_map(|k| (1..breaks.len()).map(move |i| (k, i)));
            steps.map(|(k, i)| ((value(k, i) - value(k, i - 1)) / (breaks[i] - breaks[i - 1])).abs()).fold(0.0, f64::max)
        };
        let most = |values: &[f64]| values.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let along_speed = slope(speeds, &|j, i| table.at(i, j), accels.len()) * most(speeds);
        let along_accel = slope(accels, &|i, j| table.at(i, j), speeds.len()) * most(accels);
        let bound = half_ulp * (16.0 * most(table.values()) + 2.0 * (along_speed + along_accel));
        let single = |values: &[f64]| values.iter().map(|v| f64::from(*v as f32)).collect::<Vec<_>>();
        let (speeds, accels, values) = (single(speeds), single(accels), single(table.values()));
        let narrow = |places: Vec<f64>| {
            let mut narrow: Vec<f32> = places.iter().map(|p| *p as f32).collect();
            narrow.extend(places.iter().flat_map(|p| [(*p as f32).next_up(), (*p as f32).next_down()]));
            narrow
        };
        let (mut input, mut points) = (String::new(), Vec::new());
        for speed in narrow(places(table.speed_mps().breaks())) {
            for accel in narrow(places(table.accel_mps2().breaks())).into_iter().step_by(2) {
                writeln!(input, "{} {:x} {:x}", i32::from(gear == Gear::Reverse), speed.to_bits(), accel.to_bits()).unwrap();
                points.push((f64::from(speed), f64::from(accel)));
            }
        }
        for program in programs {
            let (self_test, found) = answers(program, &input);
            assert_eq!((self_test.as_str(), found.len()), ("1", points.len()));
            for (Answer(status, torque, clamped_status, clamped), (speed, accel)) in found.iter().zip(&points) {
                // the policy is that of the library on the table as it was rounded
                let inside = lookup::bilinear(&speeds, &accels, &values, *speed, *accel);
                match (inside, table.torque_from_accel_clamped(*speed, *accel)) {
                    (_, None) => assert_eq!((*status, *torque, *clamped_status), (2, 0, 2)),
                    (inside, Some(wanted)) => {
                        let outside = i32::from(inside.is_none());
                        assert_eq!((*status, *clamped_status), (outside, outside), "at {speed} {accel}");
                        assert_eq!(*torque, if outside == 0 { *clamped } else { 0 });
                        let error = (f64::from(f32::from_bits(*clamped as u32)) - wanted).abs();
                        assert!(error <= bound, "at {speed} {accel}: {error}, bound {bound}");
                    }
                }
            }
        }
        assert!(bound < 2e-4, "the bound itself is far below any torque that matters: {bound}");
    }
}

#[test]
fn single_precision_stays_within_its_bound() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "c,rust", "--float"]).0, 0);
    let exported = maps.join("export");
    let mut programs = vec![rust_program(&exported, 32)];
    if let Some(compiler) = compiler() {
        programs.push(c_program(&compiler, &exported, 32, "-O2"));
    }
    expect_float(&programs, &maps);
}

#[test]
fn the_self_test_shows_a_damaged_table() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "c,rust"]).0, 0);
    let exported = maps.join("export");
    for name in ["pivot_map.c", "pivot_map.rs"] {
        let before = text(&exported, name);
        // the last bit of one number
        let value = tables(&maps)[0].1.at(0, 1);
        let (whole, flipped) = (format!(" {value:?},"), format!(" {:?},", value.next_up()));
        assert!(before.contains(&whole));
        std::fs::write(exported.join(name), before.replacen(&whole, &flipped, 1)).unwrap();
    }
    assert_eq!(answers(&rust_program(&exported, 64), "").0, "0");
    if let Some(compiler) = compiler() {
        assert_eq!(answers(&c_program(&compiler, &exported, 64, "-O2"), "").0, "0");
    }
}

#[test]
fn a_map_without_reverse_gear_says_so_and_compiles_without_warning() {
    let Some(compiler) = compiler() else { return };
    let (folder, maps) = copied();
    change_table2(&maps, |file| file.maps.truncate(1));
    assert_eq!(run(folder.path(), &["export", "--format", "c,rust", "--unverified"]).0, 0);
    let exported = maps.join("export");
    assert!(text(&exported, "pivot_map.h").contains("#define PIVOT_MAP_HAS_REVERSE 0"));
    let program = c_program(&compiler, &exported, 64, "-O2");
    let input = format!("1 {:x} {:x}\n", 0.1f64.to_bits(), 0.1f64.to_bits());
    assert_eq!(answers(&program, &input).1, [Answer(3, 0, 3, 0)]);
    assert_eq!(answers(&rust_program(&exported, 64), &input).1, [Answer(2, 0, 2, 0)]);
}

#[test]
fn whole_counts_of_16_bits_are_the_map_that_was_inverted_with_them_bit_for_bit() {
    let Some(compiler) = compiler() else { return };
    let (folder, maps) = copied();
    let (status, _, errors) = run(folder.path(), &["export", "--format", "c", "--int16"]);
    assert!(status == 1 && errors.contains("invert --int16"), "the map of any numbers: {errors}");
    let (status, said, errors) = run(folder.path(), &["invert", "--place", "6x10", "--int16", "--torque-raw", "0.01,-20"]);
    assert_eq!(status, 0, "{errors}");
    assert!(said.contains("6 speeds × 10 accelerations") && said.contains("raw torque: 0.01 N·m a count, -20 N·m at count 0"), "{said}");
    assert_eq!(run(folder.path(), &["export", "--format", "c,rust", "--int16", "--unverified"]).0, 0);
    let exported = maps.join("export");
    // two gears of 6 + 10 + 60 numbers of two bytes
    assert!(text(&exported, "pivot_map.h").contains("#define PIVOT_MAP_TABLE_BYTES 304\n"));
    let (input, wanted) = dense(&tables(&maps));
    for (self_test, found) in [answers(&c_program(&compiler, &exported, 64, "-O2"), &input), answers(&rust_program(&exported, 64), &input)]
    {
        assert_eq!(self_test, "1", "the tables are sound");
        assert_eq!(found.len(), wanted.len());
    }
    let (_, found) = answers(&c_program(&compiler, &exported, 64, "-O2"), &input);
    expect_same(&input, &found, &wanted);
}

#[test]
fn in_the_users_units_the_torque_is_that_of_the_library() {
    let Some(compiler) = compiler() else { return };
    let (folder, maps) = copied();
    let units = ["--speed-unit", "km/h", "--torque-unit", "%", "--torque-full-scale", "50"];
    assert_eq!(run(folder.path(), &[&["export", "--format", "c"][..], &units].concat()).0, 0);
    let exported = maps.join("export");
    let header = text(&exported, "pivot_map.h");
    assert!(header.contains("Torque [%] over front-wheel speed [km/h]") && header.contains("pivot_map_real speed_kmh"), "{header}");
    let program = c_program(&compiler, &exported, 64, "-O2");
    let table = &tables(&maps)[0].1;
    for (speed_mps, accel) in [(0.0, 0.3), (0.33, 0.4), (0.71, -0.6)] {
        let input = format!("0 {:x} {:x}\n", f64::to_bits(3.6 * speed_mps), f64::to_bits(accel));
        let (_, found) = answers(&program, &input);
        let torque_nm = 0.5 * f64::from_bits(found[0].1);
        assert!((torque_nm - table.torque_from_accel(speed_mps, accel).unwrap()).abs() < 1e-9, "{speed_mps} {accel}: {torque_nm}");
    }
}
