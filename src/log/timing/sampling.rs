//! When a periodic signal was sampled, where its times scatter or come in bursts.
//!
//! A sensor samples with the regularity of its own clock. A driver, a network or a recorder may pass several readings on at once, or stamp
//! them late. Times that scatter by more than some milliseconds are replaced: by the log's times if these are regular, otherwise by those of a
//! regular clock that fits them. Irregular times that the arrivals confirm are those of an irregular sensor, and stay.

use crate::log::signal_map::SignalName;
use crate::log::timing::message_times::TimeSource;
use crate::log::timing::regular::{Bounds, RegularClock};
use crate::log::timing::stamp_clock::{StampClock, middle};

/// Scatter of the times of a regular signal [s].
const REGULAR_S: f64 = 0.004;
/// Times this much more regular are better.
const MORE_REGULAR: f64 = 0.4;
/// Longest period of a signal whose times are corrected [s].
const LONGEST_PERIOD_S: f64 = 0.25;
/// Fewest messages that show a period.
const FEWEST: usize = 60;
/// Number of intervals over which the period is measured.
const OVER: usize = 20;
/// Largest spread of the period so measured.
const STEADY: f64 = 0.1;
/// Messages that follow within this share of a period came together.
const TOGETHER: f64 = 0.3;
/// Share of such messages in a signal that comes in bursts.
const BURSTS: f64 = 0.4;

/// The rhythm of a periodic signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rhythm {
    pub period_s: f64,
    /// Typical error of a time [s].
    pub scatter_s: f64,
    pub comes_in_bursts: bool,
}

impl Rhythm {
    /// Of times in the order of the log; `None` if they have no period.
    pub(crate) fn of(time_s: &[f64]) -> Option<Self> {
        if time_s.len() < FEWEST {
            return None;
        }
        let long: Vec<f64> = time_s.windows(OVER + 1).map(|t| (t[OVER] - t[0]) / OVER as f64).filter(|t| t.is_finite()).collect();
        let period_s = middle(long.clone()).filter(|p| *p > 0.0)?;
        let spread = 1.4826 * middle(long.iter().map(|p| (p - period_s).abs()).collect())? / period_s;
        if spread > STEADY {
            return None;
        }
        let steps = || time_s.windows(2).map(|t| t[1] - t[0]).filter(|t| t.is_finite());
        let scatter_s = 1.4826 * middle(steps().map(|t| (t - period_s).abs()).collect())? / std::f64::consts::SQRT_2;
        let together = steps().filter(|t| t.abs() < TOGETHER * period_s).count();
        Some(Self { period_s, scatter_s, comes_in_bursts: together as f64 > BURSTS * time_s.len() as f64 })
    }
}

/// The times at which a signal was sampled.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Sampled {
    /// New times [s]; absent where they stay.
    pub time_s: Option<Vec<f64>>,
    /// What stays unsure of each, apart from a common offset [s].
    pub std_s: f64,
    pub note: Option<String>,
}

/// The sampling times of a signal from its stamps, if it has some, and the log's times [s].
pub(crate) fn sampled(signal: SignalName, stamped_s: Option<&[f64]>, log_s: &[f64], clock: &StampClock) -> Sampled {
    let is_measured = matches!(signal, SignalName::Speed | SignalName::YawRate | SignalName::Torque | SignalName::TorqueFeedback);
    let time_s = stamped_s.unwrap_or(log_s);
    let Some(rhythm) = Rhythm::of(time_s).filter(|r| is_measured && r.period_s < LONGEST_PERIOD_S && r.scatter_s > REGULAR_S) else {
        return Sampled::default();
    };
    let name = clock.source.name();
    if let Some(stamped_s) = stamped_s {
        let logged = Rhythm::of(log_s);
        if let Some(logged) = logged.filter(|l| l.scatter_s < MORE_REGULAR * rhythm.scatter_s && !l.comes_in_bursts) {
            let usual_s = || middle(stamped_s.iter().zip(log_s).map(|(t, l)| t - l).collect()).unwrap_or(0.0);
            // rounded stamps are early, and one stamp for several messages late, by up to a step
            let delay_s = if rhythm.comes_in_bursts { 0.0 } else { usual_s() };
            return Sampled {
                time_s: Some(log_s.iter().map(|t| t + delay_s).collect()),
                std_s: logged.scatter_s,
                note: Some(format!(
                    "{name} of {signal}: they scatter by {:.1} ms about a period of {:.1} ms, the log's times by {:.1} ms: the log's times are used",
                    1e3 * rhythm.scatter_s,
                    1e3 * rhythm.period_s,
                    1e3 * logged.scatter_s
                )),
            };
        }
        let delays: Vec<f64> = stamped_s.iter().zip(log_s).map(|(t, l)| l - t).collect();
        let usual_s = middle(delays.clone()).unwrap_or(0.0);
        let spread_s = 1.4826 * middle(delays.iter().map(|d| (d - usual_s).abs()).collect()).unwrap_or(0.0);
        let is_confirmed = clock.source == TimeSource::Stamp && spread_s < 0.5 * rhythm.scatter_s && delays.iter().any(|d| *d != delays[0]);
        if is_confirmed && !rhythm.comes_in_bursts {
            return Sampled::default();
        }
    }
    let bounds = if rhythm.comes_in_bursts { Bounds::of_bursts(time_s, TOGETHER * rhythm.period_s) } else { Bounds::exact(time_s) };
    let Some(found) = RegularClock::fit(&bounds, &rhythm, clock.source != TimeSource::Stamp && rhythm.comes_in_bursts) else { return Sampled::default() };
    let how = if rhythm.comes_in_bursts {
        let (least, most) = bounds.burst_lengths();
        format!("the messages come in bursts of {least} to {most}")
    } else {
        format!("they scatter by {:.1} ms", 1e3 * rhythm.scatter_s)
    };
    let lost = if found.lost > 0 { format!(", {} of them lost", found.lost) } else { String::new() };
    Sampled {
        note: Some(format!(
            "{name} of {signal}: {how}: each is taken as sampled by a regular clock, every {:.2} ms{lost}",
            1e3 * found.period_s
        )),
        std_s: found.std_s,
        time_s: Some(found.time_s),
    }
}
