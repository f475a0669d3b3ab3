//! The exported lateral compensation, compiled as a controller would compile it, against the library: a long drive in both directions with
//! stops, bends, events and inputs that are no numbers.
#![allow(clippy::unwrap_used)]

#[path = "common/compiled.rs"]
mod compiled;
#[path = "common/map_copy.rs"]
mod map_copy;
#[path = "common/readers.rs"]
mod readers;

use map_copy::{copied, run, text};
use pivot_cal::control::{CompensationEntry, CompensationSettings, CompensationTable, Gear, LateralCompensation};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const C_HARNESS: &str = r#"
#include "lateral_compensation.h"
#include <inttypes.h>
#include <stdio.h>
typedef union { lateral_real number; uint64_t bits; } word;
int main(void)
{
    int gear, tracking;
    word error, travelled, curvature, out;
    lateral_state state;
    lateral_compensation_start(&state);
    printf("%d\n", lateral_compensation_self_test());
    while (scanf("%d %d %" SCNx64 " %" SCNx64 " %" SCNx64, &gear, &tracking, &error.bits, &travelled.bits, &curvature.bits) == 5) {
        out.number = lateral_compensation_angle(error.number);
        printf("%" PRIx64 " ", out.bits);
        out.number = lateral_compensation_step(&state, (lateral_gear)gear, error.number, travelled.number, curvature.number, tracking);
        printf("%" PRIx64 "\n", out.bits);
    }
    return 0;
}
"#;

const RUST_HARNESS: &str = r#"
#![no_std]
extern crate std;
mod lateral_compensation;
use lateral_compensation::{Gear, LateralCompensation};
use std::io::BufRead;
use std::println;
fn main() {
    println!("{}", i32::from(lateral_compensation::self_test()));
    let mut law = LateralCompensation::default();
    for line in std::io::stdin().lock().lines() {
        let line = line.unwrap();
        let mut words = line.split(' ');
        let gear = if words.next() == Some("0") { Gear::Forward } else { Gear::Reverse };
        let tracking = words.next() == Some("1");
        let mut number = || f64::from_bits(u64::from_str_radix(words.next().unwrap(), 16).unwrap());
        let (error, travelled, curvature) = (number(), number(), number());
        let angle = lateral_compensation::angle(error);
        println!("{:x} {:x}", angle.to_bits(), law.step(gear, error, travelled, curvature, tracking).to_bits());
    }
}
"#;

/// The committed table as the library reads it.
fn table(maps: &Path) -> CompensationTable {
    let file: serde_json::Value = serde_json::from_str(&text(maps, "lateral_table.json")).unwrap();
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let entry = |e: &serde_json::Value, a: &serde_json::Value| CompensationEntry { error_m: number(e), angle_rad: number(a) };
    let entries: Vec<_> = file["entries"].as_array().unwrap().iter().map(|e| entry(&e["error_m"], &e["angle_rad"])).collect();
    let curve = |name: &str| file["curve"][name].as_array().unwrap().clone();
    let points: Vec<_> = curve("error_m").iter().zip(&curve("angle_rad")).map(|(e, a)| entry(e, a)).collect();
    CompensationTable::new(&entries, &points).unwrap()
}

/// Inputs of a drive, and the library's answers: the look-up, and the compensation.
fn drive(table: &CompensationTable) -> (String, Vec<(u64, u64)>) {
    let mut law = LateralCompensation::new(CompensationSettings::default(), *table);
    let (mut input, mut wanted, mut random) = (String::new(), Vec::new(), 1_u64);
    for k in 0..40_000_u32 {
        // a multiplicative congruential generator is random enough for inputs
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        let noise = (random >> 40) as f64 / f64::from(1 << 24) - 0.5;
        let gear = if (k / 9000) % 2 == 0 { Gear::Forward } else { Gear::Reverse };
        let tracking = k % 5000 > 40;
        let mut error_m = 0.05 * gear.sign() + 0.004 * noise + if k > 20_000 { 0.03 } else { 0.0 };
        let mut curvature_per_m = if k % 4000 > 3700 { 0.2 } else { 0.0 };
        let mut travelled_m = 0.016 + 0.001 * noise;
        match k % 7919 {
            11 => error_m = f64::NAN,
            12 => error_m = 0.9,
            13 => travelled_m = f64::INFINITY,
            14 => travelled_m = f64::NAN,
            15 => curvature_per_m = f64::NAN,
            16 => error_m = f64::NEG_INFINITY,
            17 => travelled_m = -0.1,
            _ => {}
        }
        let numbers = [error_m, travelled_m, curvature_per_m].map(f64::to_bits);
        let gear_number = i32::from(gear == Gear::Reverse);
        writeln!(input, "{gear_number} {} {:x} {:x} {:x}", i32::from(tracking), numbers[0], numbers[1], numbers[2]).unwrap();
        let angle = table.angle_rad(error_m, CompensationSettings::default().exact_m);
        wanted.push((angle.to_bits(), law.step(gear, error_m, travelled_m, curvature_per_m, tracking).to_bits()));
    }
    assert!(law.in_force_rad(Gear::Forward).abs() > 0.01 && law.in_force_rad(Gear::Reverse).abs() > 0.01, "the drive compensates");
    (input, wanted)
}

fn answers(program: &Path, input: &str) -> (String, Vec<(u64, u64)>) {
    let bits = |word: &str| u64::from_str_radix(word, 16).unwrap();
    compiled::answers(program, input, |line| line.split_once(' ').map(|(a, b)| (bits(a), bits(b))).unwrap())
}

fn expect(program: &Path, input: &str, wanted: &[(u64, u64)]) {
    let (self_test, found) = answers(program, input);
    assert_eq!((self_test.as_str(), found.len()), ("1", wanted.len()));
    for ((line, found), wanted) in input.lines().zip(&found).zip(wanted) {
        // zeros of either sign are one number
        let same = |a: u64, b: u64| a == b || (f64::from_bits(a) == 0.0 && f64::from_bits(b) == 0.0);
        assert!(same(found.0, wanted.0) && same(found.1, wanted.1), "at {line}: {found:x?}, wanted {wanted:x?}");
    }
}

fn rust_program(folder: &Path) -> PathBuf {
    compiled::rust_program(folder, RUST_HARNESS)
}

#[test]
fn the_exported_law_is_the_librarys_bit_for_bit() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "c,rust"]).0, 0);
    let (exported, (input, wanted)) = (maps.join("export"), drive(&table(&maps)));
    expect(&rust_program(&exported), &input, &wanted);
    let c_program = |compiler: &Path, optimise| compiled::c_program(compiler, &exported, C_HARNESS, "lateral_compensation.c", optimise);
    match compiled::c_compiler() {
        Some(compiler) => ["-O0", "-O2"].into_iter().for_each(|o| expect(&c_program(&compiler, o), &input, &wanted)),
        None => readers::not_tested("C export of the lateral compensation", "there is no C compiler"),
    }
}

#[test]
fn the_self_test_shows_a_damaged_table_and_without_a_table_there_is_no_law() {
    let (folder, maps) = copied();
    assert_eq!(run(folder.path(), &["export", "--format", "rust"]).0, 0);
    let exported = maps.join("export");
    let before = text(&exported, "lateral_compensation.rs");
    let value = table(&maps).points()[0].angle_rad;
    let (whole, flipped) = (format!(" {value:?},"), format!(" {:?},", value.next_up()));
    assert!(before.contains(&whole));
    std::fs::write(exported.join("lateral_compensation.rs"), before.replacen(&whole, &flipped, 1)).unwrap();
    assert_eq!(answers(&rust_program(&exported), "").0, "0");
    std::fs::remove_file(maps.join("lateral_table.json")).unwrap();
    assert_eq!(run(folder.path(), &["export", "--format", "c", "-o", "none"]).0, 0);
    assert!(folder.path().join("none/pivot_map.c").exists() && !folder.path().join("none/lateral_compensation.c").exists());
}
