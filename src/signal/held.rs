//! Signals whose values hold until the next message, as if they were logged all the time.

use crate::log::MessageKind;
use crate::signal::{Series, median};

/// Time between the values of a held signal [s]: that of a usual command.
const FILL_S: f64 = 0.02;
/// Most values that are filled in.
const MOST_FILLED: f64 = 4e6;

/// Converts a signal that is logged on change to one that is logged every 20 ms until `end_s`: each value is repeated until the next
/// message, and every change keeps its own time.
pub(crate) fn held_until(series: &Series, end_s: f64) -> Series {
    let (Some(&first_s), Some(&last_s)) = (series.t_s.first(), series.t_s.last()) else { return series.clone() };
    let end_s = end_s.max(last_s);
    let step_s = FILL_S.max((end_s - first_s) / MOST_FILLED);
    let mut filled = Series::default();
    for k in 0..series.len() {
        let next_s = series.t_s.get(k + 1).copied();
        let count = ((next_s.unwrap_or(end_s) - series.t_s[k]) / step_s - if next_s.is_some() { 1e-6 } else { -1e-6 }).max(0.0) as usize;
        for n in 0..=count {
            filled.t_s.push(series.t_s[k] + n as f64 * step_s);
            filled.value.push(series.value[k]);
        }
    }
    filled
}

/// The note on a signal whose values hold; `None` for a periodic one.
pub(crate) fn held_note(signal: &str, kind: MessageKind, series: &Series) -> Option<String> {
    let span_s = series.t_s.last().zip(series.t_s.first()).map_or(0.0, |(last, first)| last - first);
    match kind {
        MessageKind::Periodic | MessageKind::PeriodicWithLosses => None,
        MessageKind::OnChange => {
            Some(format!("{signal} is logged on change: {} messages in {span_s:.0} s; a value holds until the next one", series.len()))
        }
        MessageKind::OnChangeWithHeartbeat => {
            let intervals: Vec<f64> = series.t_s.windows(2).map(|t| t[1] - t[0]).collect();
            Some(format!(
                "{signal} is logged on change, with a heartbeat every {:.2} s; a value holds until the next one",
                median(&intervals)
            ))
        }
        MessageKind::Once => Some(format!("{signal} is logged once, at {:.1} s; its value holds for the whole log", series.t_s.first()?)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_signal_keeps_the_time_of_every_change_and_lasts_to_the_end() {
        let series = Series { t_s: vec![0.0, 1.013, 1.02], value: vec![0.0, 12.0, 5.0] };
        let filled = held_until(&series, 2.0);
        assert!(filled.t_s.windows(2).all(|t| t[1] > t[0] && t[1] - t[0] < 0.0201));
        assert_eq!((filled.held(1.0129), filled.held(1.013), filled.held(1.02)), (Some(0.0), Some(12.0), Some(5.0)));
        assert!((filled.t_s[filled.len() - 1] - 2.0).abs() < 0.021);
        assert_eq!(held_until(&Series::default(), 3.0), Series::default());
    }
}
