//! Campaigns cut to a time, driven on the simulator and surveyed.

use pivot_cal::campaign;
use pivot_cal::campaign::Survey;
use pivot_cal::internals::{Campaign, RunGroup, Torques, VehicleFile, record};
use pivot_cal::log::{Source, VehicleOverrides, read_bytes};
use pivot_cal::map::Gear;
use pivot_cal::signal::Track;

use super::Fallible;

/// Single runs in the order of driving.
pub(crate) type Runs = Vec<RunGroup>;

/// The runs of a campaign one by one, in its own order.
pub(crate) fn in_order(campaign: &Campaign) -> Fallible<Runs> {
    Ok(campaign
        .plan(campaign.seed)?
        .into_iter()
        .map(|run| RunGroup { torque_nm: Torques::One(run.torque_nm), repeats: 1, shuffle: false, ..run.settings })
        .collect())
}

/// The runs of a campaign in an order drawn from `seed`, the gears in turn as long as both are left, `rounds` times over: whole rounds hold
/// each run as often as the campaign does, and the first minute holds both gears.
pub(crate) fn shuffled(campaign: &Campaign, seed: u64, rounds: u64) -> Fallible<Runs> {
    let single = in_order(campaign)?;
    let mut runs = Vec::new();
    let single = &single;
    for round in 0..rounds {
        // a separate order: by a hash of place, round and seed
        let key =
            |k: usize| (k as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15 ^ (seed + 1000 * round).wrapping_mul(0xD134_2543_DE82_EF95)) >> 20;
        let mut order: Vec<usize> = (0..single.len()).collect();
        order.sort_by_key(|k| (key(*k), *k));
        let [mut forward, mut reverse] = Gear::ALL.map(|gear| order.iter().filter(move |k| single[**k].gear == gear));
        loop {
            let pair = [forward.next(), reverse.next()];
            if pair == [None, None] {
                break;
            }
            runs.extend(pair.into_iter().flatten().map(|k| single[*k].clone()));
        }
    }
    Ok(runs)
}

/// What was driven.
pub(crate) struct Driven {
    pub(crate) survey: Survey,
    /// Length of the log [s].
    pub(crate) seconds: f64,
    /// How many of the runs fitted into the time.
    pub(crate) runs: usize,
}

/// Drives as many of `runs` as fit into `limit_s`, with the message timing of `campaign` and noise from `seed`.
pub(crate) fn drive(vehicle: &VehicleFile, campaign: &Campaign, runs: &[RunGroup], limit_s: f64, seed: u64) -> Fallible<Driven> {
    let mut runs = runs.to_vec();
    loop {
        let recording = record(vehicle, &Campaign { runs: runs.clone(), ..campaign.clone() }, Some(seed))?;
        let seconds = recording.report.duration_s;
        if seconds <= limit_s {
            let name = format!("{}_{seed}.mcap", campaign.name.replace(' ', "_"));
            let log = read_bytes(recording.bytes, &name, &Source::Detect, &VehicleOverrides::default())?;
            let survey = Survey::new(Track::new(&log)?, &campaign::SurveySettings::default())?;
            return Ok(Driven { survey, seconds, runs: runs.len() });
        }
        // as many as ended in time, one fewer each time after that
        let in_time = recording.report.runs.iter().filter(|r| r.start_s + r.duration_s <= limit_s).map(|r| r.group + 1).max().unwrap_or(0);
        runs.truncate(in_time.min(runs.len() - 1));
    }
}
