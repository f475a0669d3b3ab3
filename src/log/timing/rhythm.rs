//! The rhythm of a signal: its period, how much its times scatter, and whether its messages come in bursts.

/// Fewest messages that show a period.
const FEWEST: usize = 60;
/// Number of intervals over which the period is measured.
const OVER: usize = 20;
/// Largest spread of this measured period.
const STEADY: f64 = 0.2;
/// Messages closer together than this share of a period arrived together.
pub(crate) const TOGETHER: f64 = 0.3;
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
    /// The rhythm of times in the order of the log; `None` if they have no period.
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

/// Median, the upper one of an even number; `None` for no values.
pub(crate) fn middle(mut values: Vec<f64>) -> Option<f64> {
    let at = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(at, f64::total_cmp).1)
}
