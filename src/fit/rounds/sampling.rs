//! The stretches for the first iterations: enough of every torque to find delays and noise, however long the logs are.

use crate::campaign::Survey;
use crate::fit::motion::log_data::LogData;
use crate::map::Gear;
use std::collections::BTreeMap;

/// Moving time that determines delays and noise well enough for a start [s]; shared by the logs, but each has its own dead time.
const ENOUGH_S: f64 = 160.0;
const ENOUGH_PER_LOG_S: f64 = 60.0;
/// Stretches of every torque, gear and log that are always used.
const OF_EACH: usize = 3;
/// Torques nearer than this share of the largest count as one.
const SAME_TORQUE: f64 = 0.04;

/// The choice for every log, and whether anything was skipped.
pub(crate) fn choose(logs: &[LogData]) -> (Vec<Vec<bool>>, bool) {
    let enough_s = (ENOUGH_S / logs.len().max(1) as f64).max(ENOUGH_PER_LOG_S);
    let chosen: Vec<Vec<bool>> = logs.iter().map(|l| of_log(l.survey, enough_s)).collect();
    let less = chosen.iter().flatten().any(|c| !c);
    (chosen, less)
}

fn of_log(survey: &Survey, enough_s: f64) -> Vec<bool> {
    let total_s: f64 = survey.stretches.iter().map(|s| s.to_s - s.from_s).sum();
    if total_s <= 1.25 * enough_s {
        return vec![true; survey.stretches.len()];
    }
    let largest = survey.track.command_nm.value.iter().fold(1e-9f64, |m, v| m.max(v.abs()));
    let level = |torque_nm: f64| (torque_nm / (SAME_TORQUE * largest)).round() as i64;
    let mut order: Vec<usize> = (0..survey.stretches.len()).collect();
    order.sort_by_key(|k| (scramble(*k as u64), *k));
    let mut chosen = vec![false; survey.stretches.len()];
    let mut taken_s = 0.0;
    let mut seen: BTreeMap<(i64, bool), usize> = BTreeMap::new();
    for &k in &order {
        let stretch = &survey.stretches[k];
        let holds = survey.holds.iter().filter(|h| h.to_s > stretch.from_s && h.from_s < stretch.to_s);
        let mut levels: Vec<(i64, bool)> = holds.map(|h| (level(h.torque_nm), stretch.gear == Gear::Forward)).collect();
        levels.sort_unstable();
        levels.dedup();
        if levels.iter().any(|l| seen.get(l).is_none_or(|n| *n < OF_EACH)) {
            for level in levels {
                *seen.entry(level).or_insert(0) += 1;
            }
            chosen[k] = true;
            taken_s += stretch.to_s - stretch.from_s;
        }
    }
    for k in order {
        if !chosen[k] && taken_s < enough_s {
            chosen[k] = true;
            taken_s += survey.stretches[k].to_s - survey.stretches[k].from_s;
        }
    }
    chosen
}

/// A well mixed 64-bit number. Source: Steele, Lea & Flood 2014, *Fast splittable pseudorandom number generators* (SplitMix64).
pub(crate) fn scramble(k: u64) -> u64 {
    let mut z = k.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
