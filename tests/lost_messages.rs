//! Lost messages of the torque command: a step is then logged late, and the fit must not explain the motion before it by the vehicle, nor by a
//! drive that is not a first-order lag.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // the figures are worth seeing
#![allow(dead_code)] // the study needs more of its yardstick than this

#[path = "common/yardstick.rs"]
mod yardstick;

use pivot_cal::campaign;
use pivot_cal::campaign::Survey;
use pivot_cal::fit;
use pivot_cal::fit::fit;
use pivot_cal::internals::{Campaign, VehicleFile, record};
use pivot_cal::log::{Source, VehicleOverrides, read_bytes};
use pivot_cal::map::{Gear, Table1File};
use pivot_cal::signal::Track;
use yardstick::{Cell, Yardstick, inverse, rms};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

/// Hard steps on the way: spin-ups by 40 N·m and braking, and starts from rest.
const CAMPAIGN: &str = "[[runs]]\ntorque_nm = [-24, -20, -16, -8, 0]\nstart_speed_mps = 0.95\nspin_up_nm = 40\nend_speed_mps = 0.3\nhold_s = 2.5\n\
                        repeats = 8\nshuffle = true\npause_s = 0.1\n\
                        [[runs]]\ntorque_nm = [12, 20, 28, 40]\nhold_s = 2.5\nrepeats = 5\nshuffle = true\npause_s = 0.1\n";

/// Torque error of the map [N·m], root mean square between 0.05 and 1.0 m/s and over some campaigns, when so many of the command's messages
/// are lost.
fn error_nm(lost_fraction: f64) -> f64 {
    let vehicle = VehicleFile::from_toml(include_str!("../data/vehicles/scrubber.toml")).unwrap();
    let yardstick = Yardstick::new(&vehicle, 1.0, [-24.0, 40.0]).unwrap();
    let mut campaign = Campaign::from_toml(CAMPAIGN).unwrap();
    campaign.topics.torque_command.lost_fraction = lost_fraction;
    let of_seed = |seed: u64| {
        let bytes = record(&vehicle, &campaign, Some(seed)).unwrap().bytes;
        let log = read_bytes(bytes, "lost.mcap", &Source::Detect, &VehicleOverrides::default()).unwrap();
        let survey = Survey::new(Track::new(&log).unwrap(), &campaign::SurveySettings::default()).unwrap();
        let file = fit(vec![survey], &fit::FitSettings::default()).unwrap().file;
        yardstick.rms_between(&forward(&yardstick, &file), 0.05, 1.0)
    };
    rms(&(1..=4).map(of_seed).collect::<Vec<_>>())
}

/// Errors of the surface in the forward gear; none in the other, which was not driven.
fn forward(yardstick: &Yardstick, file: &Table1File) -> Vec<f64> {
    let surface = file.maps[0].surface.table().unwrap();
    let of = |cell: &Cell| {
        if cell.gear == Gear::Forward { inverse(&surface, cell.speed_mps, cell.accel_mps2) - cell.torque_nm } else { 0.0 }
    };
    yardstick.cells.iter().map(of).collect()
}

#[test]
fn one_command_message_in_twenty_may_be_lost() {
    let (whole_nm, lost_nm) = (error_nm(0.0), error_nm(0.05));
    println!("{whole_nm:.4} N·m with every message, {lost_nm:.4} N·m with one in twenty lost");
    assert!(lost_nm < 1.4 * whole_nm, "{whole_nm} {lost_nm}");
}
