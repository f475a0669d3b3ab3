//! What a fit costs after the logs are read: 5, 15 and 60 minutes of 50 Hz encoder and 100 Hz yaw rate, on one thread.
//!
//! Each length is printed against the limit: 60 minutes in 1.5 s.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a benchmark prints
#![allow(dead_code)] // the study needs more of its drives than this

#[path = "../tests/common/study/drive.rs"]
mod drive;
#[path = "../tests/common/study/vehicle.rs"]
mod vehicle;

use pivot_cal::campaign;
use pivot_cal::campaign::Survey;
use pivot_cal::fit;
use pivot_cal::fit::fit;
use std::time::Instant;

/// Limit for an hour of data on one thread [s].
const HOUR_S: f64 = 1.5;

fn main() {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    threads.install(|| {
        let track = drive::Drive::new(&vehicle::truth(vehicle::Kind::Physics), 3600.0, 1).track;
        let started = Instant::now();
        let survey = Survey::new(track, &campaign::SurveySettings::default()).unwrap();
        let surveyed_s = started.elapsed().as_secs_f64();
        fit(vec![survey], &fit::FitSettings::default()).unwrap();
        let whole_s = started.elapsed().as_secs_f64();
        println!("60 min: {whole_s:.2} s (survey {surveyed_s:.2} s), limit {HOUR_S} s: {:.2} × it", whole_s / HOUR_S);
    });
    divan::main();
}

/// Survey and fit of so many minutes.
#[divan::bench(args = [5, 15, 60], max_time = 20, sample_count = 3)]
fn survey_and_fit(bencher: divan::Bencher<'_, '_>, minutes: u32) {
    let threads = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let track = drive::Drive::new(&vehicle::truth(vehicle::Kind::Physics), 60.0 * f64::from(minutes), 1).track;
    bencher.bench_local(|| {
        threads.install(|| {
            let survey = Survey::new(track.clone(), &campaign::SurveySettings::default()).unwrap();
            fit(vec![survey], &fit::FitSettings::default()).unwrap()
        })
    });
}
