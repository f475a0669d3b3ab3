//! `export`: the map in the formats of controllers and calibration tools.

use crate::cli::Ui;
use crate::cli::one_of::OneOf;
use crate::cli::outcome::Outcome;
use crate::export::{ExportSettings, Format, MapSource, Precision, UnitNumbers, UserUnit, UserUnits};
use crate::map::{RawUnit, sha256_hex, write_whole};
use crate::text::shown;
use anyhow::bail;
use std::path::PathBuf;

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal export --format c
  pivot-cal export --format c --float -o firmware/generated
  pivot-cal export --format autoware,apollo,dcm,cdfx,a2l,rust,json
  pivot-cal export --format c --speed-unit km/h --torque-unit % --torque-full-scale 44
  pivot-cal export --format c --int16        whole counts of 16 bits, of a map of `invert --int16`

  c         pivot_map.h, pivot_map.c        C99, no dependency, no allocation, checksum with self-test
  rust      pivot_map.rs                    a module that needs core only
            lateral_compensation.*          with c and rust, if the folder has lateral_table.json
  autoware  accel_map.csv, brake_map.csv    acceleration over speed and pedal, from Table 1
  apollo    calibration_table.pb.txt        protobuf text
  dcm       pivot_map.dcm                   DCM 2.0
  cdfx      pivot_map.cdfx                  ASAM CDF 2.0
  a2l       pivot_map.a2l                   ASAP2 1.71 of the exported C, addresses open
  json      pivot_map.json                  table2.json with its JSON Schema
  controller-c  pivot_controller.{h,c}      the whole controller in C99 with settings and maps, bit for bit the verified one, and
            pivot_controller_library.c      the template of a shared library for verify --controller
  fmu       plant_fmi2.fmu, plant_fmi3.fmu  the identified plant of Table 1 for co-simulation: C sources, and a binary where there is a C compiler

Reverse gear is in the same file, or in one with .reverse before its extension. A map whose hashes do not match is refused.
The verdict on the map is in the header of every file. Without a verify.json that judged every pivot of this map and passed, nothing is
written, unless --unverified is given; then every file says so.
Exit status: 0 written, 3 the map is not verified, 1 error.")]
pub(crate) struct Arguments {
    /// Form of the map: c, rust, autoware, apollo, dcm, cdfx, a2l, json, controller-c, fmu; several with commas
    #[arg(long, value_name = "NAME", required = true, value_delimiter = ',', value_parser = OneOf::new(Format::ALL.map(Format::name), format),
        hide_possible_values = true)]
    format: Vec<Format>,
    /// Folder with table1.json and table2.json
    #[arg(long, value_name = "DIR", default_value = "maps")]
    maps: PathBuf,
    /// Export a map without a passed verdict; every file says UNVERIFIED in its header
    #[arg(long)]
    unverified: bool,
    /// Folder to write into, by default `export` in the folder of the map; `-` is standard output, for a format of one file
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Wheel angle of the map [°]; by default the test angle. JSON always holds all
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    angle: Option<f64>,
    /// Unit of the speeds (C, Rust, DCM, CDFX, A2L): m/s, km/h, mm/s, rpm or rad/s of the wheel, or raw with --speed-scale
    #[arg(long, value_name = "UNIT")]
    speed_unit: Option<String>,
    /// Speed of one raw count [m/s]; by default that of the map
    #[arg(long, value_name = "MPS", requires = "speed_unit")]
    speed_scale: Option<f64>,
    /// Speed of the raw count 0 [m/s]
    #[arg(long, value_name = "MPS", requires = "speed_scale", allow_negative_numbers = true)]
    speed_offset: Option<f64>,
    /// Unit of the torques (C, Rust, DCM, CDFX, A2L): N.m, mN.m, %, permille, A with --torque-scale, or raw with --torque-scale
    #[arg(long, value_name = "UNIT")]
    torque_unit: Option<String>,
    /// Torque of one ampere or raw count [N·m]; of a count by default that of the map
    #[arg(long, value_name = "NM", requires = "torque_unit")]
    torque_scale: Option<f64>,
    /// Torque of the raw count 0 [N·m]
    #[arg(long, value_name = "NM", requires = "torque_scale", allow_negative_numbers = true)]
    torque_offset: Option<f64>,
    /// Torque that is 100 % [N·m]: of % and permille, and of the pedals of Autoware and Apollo; by default the vehicle's
    #[arg(long, value_name = "NM")]
    torque_full_scale: Option<f64>,
    /// Tables as whole counts of 16 bits (C and Rust), of a map that was inverted with --int16 or raw units
    #[arg(long)]
    int16: bool,
    /// FMUs with their C sources alone, without a binary for this machine
    #[arg(long)]
    sources_only: bool,
    /// Tables and look-up in single precision (C and Rust)
    #[arg(long)]
    float: bool,
    /// Tables and look-up in double precision (C and Rust); the default
    #[arg(long, conflicts_with = "float")]
    double: bool,
}

fn format(text: &str) -> Result<Format, String> {
    let known = || Format::ALL.map(Format::name).join(", ");
    Format::ALL.into_iter().find(|f| f.name() == text).ok_or_else(|| format!("{text:?} is not known; allowed: {}", known()))
}

#[derive(serde::Serialize)]
struct Written {
    format: &'static str,
    file: String,
    bytes: usize,
    sha256: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    note: Option<String>,
}

/// The settings of the export; what a unit lacks is taken from the map.
fn settings(arguments: &Arguments, source: &MapSource) -> anyhow::Result<ExportSettings> {
    if let Some(found) = arguments.torque_full_scale.filter(|full| !(full.is_finite() && *full > 0.0)) {
        bail!("--torque-full-scale is {found}; allowed: above 0");
    }
    let full_scale_nm = arguments.torque_full_scale.or(source.table2.vehicle.torque_full_scale_nm);
    let raw = source.table2.raw.unwrap_or_default();
    let numbers = |name: &str, scale: Option<f64>, offset: Option<f64>, raw: Option<RawUnit>| {
        let of_map = raw.filter(|_| name == "raw" && scale.is_none());
        UnitNumbers { scale: scale.or(of_map.map(|r| r.scale)), offset: offset.or(of_map.map(|r| r.offset)), full_scale_nm }
    };
    let speed = arguments.speed_unit.as_deref().map(|name| {
        let numbers = numbers(name, arguments.speed_scale, arguments.speed_offset, raw.speed_mps);
        UserUnit::of_speed(name, numbers, source.table2.vehicle.wheel_radius_m)
    });
    let torque = arguments.torque_unit.as_deref().map(|name| {
        let numbers = numbers(name, arguments.torque_scale, arguments.torque_offset, raw.torque_nm);
        UserUnit::of_torque(name, UnitNumbers { full_scale_nm: full_scale_nm.or(Some(source.full_torque_nm())), ..numbers })
    });
    let precision = if arguments.float { Precision::Float } else { Precision::Double };
    let units = UserUnits { speed: speed.transpose()?, torque: torque.transpose()? };
    Ok(ExportSettings { precision, int16: arguments.int16, units, full_scale_nm, without_binary: arguments.sources_only })
}

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(arguments.output.as_deref().filter(|output| output.as_os_str() == "-"))?;
    let source = MapSource::read_at(&arguments.maps, arguments.angle)?;
    if !source.other_angles_deg.is_empty() {
        let others: Vec<String> = source.other_angles_deg.iter().map(|a| format!("{a}°")).collect();
        let angle_deg = source.table2.vehicle.test_angle_deg;
        ui.say(format!("the map of {angle_deg}°; table2.json also holds {} (--angle)", others.join(", ")));
    }
    let settings = settings(arguments, &source)?;
    let folder = arguments.output.clone().unwrap_or_else(|| arguments.maps.join("export"));
    // all forms first: nothing is written if one of them is impossible
    let mut files = Vec::new();
    for format in &arguments.format {
        files.extend(format.files(&source, &settings)?.into_iter().map(|file| (*format, file)));
    }
    let printed = folder.as_os_str() == "-";
    if printed && files.len() > 1 {
        let names: Vec<&str> = files.iter().map(|(_, file)| file.name.as_str()).collect();
        bail!(
            "-o - is standard output, and there are {} files ({}); give a folder, or one format with one file",
            names.len(),
            names.join(", ")
        );
    }
    let proof = &source.proof;
    if !proof.is_verified && !arguments.unverified {
        ui.document(&serde_json::json!({ "refused": proof.reason }))?;
        let folder = shown(&arguments.maps);
        Ui::refuse(format!(
            "nothing is written: {}; `pivot-cal verify --maps {folder}` judges the map, and --unverified exports it as it is",
            proof.reason
        ));
        return Ok(Outcome::Rejected);
    }
    ui.say(proof.line());
    let mut written = Vec::new();
    for (format, file) in files {
        let path = if printed { folder.clone() } else { folder.join(&file.name) };
        write_whole(&path, file.content())?;
        let note = file.note.as_ref().map_or(String::new(), |note| format!(" ({note})"));
        ui.say(format!("written: {}{note}", shown(&path)));
        let (bytes, sha256) = (file.content().len(), sha256_hex(file.content()));
        written.push(Written { format: format.name(), file: shown(&path), bytes, sha256, note: file.note });
    }
    ui.document(&written)?;
    Ok(Outcome::Done)
}
