//! `export`: the map in the formats of controllers and calibration tools.

use crate::cli::Ui;
use crate::cli::outcome::Outcome;
use crate::export::{Format, MapSource, Precision};
use crate::map::{sha256_hex, write_whole};
use crate::text::shown;
use anyhow::bail;
use std::path::PathBuf;

/// Arguments of `export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  pivot-cal export --format c
  pivot-cal export --format c --float -o firmware/generated
  pivot-cal export --format autoware,apollo,dcm,cdfx,rust,json

  c         pivot_map.h, pivot_map.c        C99, no dependency, no allocation, checksum with self-test
  rust      pivot_map.rs                    a module that needs core only
            lateral_compensation.*          with c and rust, if the folder has lateral_table.json
  autoware  accel_map.csv, brake_map.csv    acceleration over speed and pedal, from Table 1
  apollo    calibration_table.pb.txt        protobuf text
  dcm       pivot_map.dcm                   DCM 2.0
  cdfx      pivot_map.cdfx                  ASAM CDF 2.0
  json      pivot_map.json                  table2.json with its JSON Schema

Reverse gear is in the same file, or in one with .reverse before its extension. A map whose hashes do not match is refused.
The verdict on the map is in the header of every file. Without a verify.json that judged every pivot of this map and passed, nothing is
written, unless --unverified is given; then every file says so.
Exit status: 0 written, 3 the map is not verified, 1 error.")]
pub(crate) struct Arguments {
    /// Form of the map: c, rust, autoware, apollo, dcm, cdfx, json; several with commas
    #[arg(long, value_name = "NAME", required = true, value_delimiter = ',', value_parser = format)]
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

pub(crate) fn run(arguments: &Arguments, ui: Ui) -> anyhow::Result<Outcome> {
    let ui = ui.beside(arguments.output.as_deref().filter(|output| output.as_os_str() == "-"))?;
    let source = MapSource::read_at(&arguments.maps, arguments.angle)?;
    if !source.other_angles_deg.is_empty() {
        let others: Vec<String> = source.other_angles_deg.iter().map(|a| format!("{a}°")).collect();
        let angle_deg = source.table2.vehicle.test_angle_deg;
        ui.say(format!("the map of {angle_deg}°; table2.json also holds {} (--angle)", others.join(", ")));
    }
    let precision = if arguments.float { Precision::Float } else { Precision::Double };
    let folder = arguments.output.clone().unwrap_or_else(|| arguments.maps.join("export"));
    // all forms first: nothing is written if one of them is impossible
    let mut files = Vec::new();
    for format in &arguments.format {
        files.extend(format.files(&source, precision)?.into_iter().map(|file| (*format, file)));
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
        write_whole(&path, file.text.as_bytes())?;
        let note = file.note.as_ref().map_or(String::new(), |note| format!(" ({note})"));
        ui.say(format!("written: {}{note}", shown(&path)));
        let (bytes, sha256) = (file.text.len(), sha256_hex(file.text.as_bytes()));
        written.push(Written { format: format.name(), file: shown(&path), bytes, sha256, note: file.note });
    }
    ui.document(&written)?;
    Ok(Outcome::Done)
}
