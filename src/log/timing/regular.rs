//! A regular clock fitted to times that scatter or are known only to lie within bounds.
//!
//! In: bounds [lo, hi] of the true time of each message, equal where a time is only noisy. Out: t = t₀ + n·T, with the number n of each
//! period. Consecutive messages differ by one period, or by more where messages were lost. Dynamic programming over the sequence
//! (Viterbi) finds which: each survivor has its own phase, which follows the bounds slowly; a lost message costs as much as an error of
//! some standard deviations. The line through the bounds is then fitted in overlapping windows, so that a slow drift is followed.

use crate::log::timing::rhythm::{Rhythm, middle};

/// Bounds of the true time of each message [s].
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Bounds {
    lo_s: Vec<f64>,
    hi_s: Vec<f64>,
    /// Number of messages of each burst.
    bursts: Vec<usize>,
}

impl Bounds {
    /// Times that scatter.
    pub(crate) fn exact(time_s: &[f64]) -> Self {
        Self { lo_s: time_s.to_vec(), hi_s: time_s.to_vec(), bursts: Vec::new() }
    }

    /// Times of messages that follow each other within `together_s` and were sampled since the burst before.
    pub(crate) fn of_bursts(time_s: &[f64], together_s: f64) -> Self {
        let mut bounds = Self { lo_s: Vec::new(), hi_s: time_s.to_vec(), bursts: Vec::new() };
        let mut starts = vec![0];
        starts.extend((1..time_s.len()).filter(|&k| time_s[k] - time_s[k - 1] >= together_s));
        let intervals: Vec<f64> = starts.windows(2).map(|s| time_s[s[1]] - time_s[s[0]]).collect();
        let usual_s = middle(intervals).unwrap_or(0.0);
        for (number, &start) in starts.iter().enumerate() {
            let end = starts.get(number + 1).copied().unwrap_or(time_s.len());
            // after a pause, the messages are still as recent as usual
            let before_s = if start > 0 { time_s[start - 1] } else { f64::NEG_INFINITY };
            // stamps that scatter may go back within a burst, and behind the one before
            let hi_s = time_s[end - 1];
            let lo_s = before_s.max(time_s[start] - 1.5 * usual_s).min(hi_s);
            bounds.lo_s.extend(std::iter::repeat_n(lo_s, end - start));
            bounds.hi_s[start..end].fill(hi_s);
            bounds.bursts.push(end - start);
        }
        bounds
    }

    /// The usual range of the lengths of bursts.
    pub(crate) fn burst_lengths(&self) -> (usize, usize) {
        let mut lengths = self.bursts.clone();
        lengths.sort_unstable();
        let at = |share: usize| lengths.get(lengths.len() * share / 100).copied().unwrap_or(1);
        (at(5), at(95))
    }

    fn len(&self) -> usize {
        self.lo_s.len()
    }

    fn centre_s(&self, k: usize) -> f64 {
        0.5 * (self.lo_s[k] + self.hi_s[k])
    }

    /// How far a time is outside the bounds of a message [s]: positive before them.
    fn miss_s(&self, k: usize, time_s: f64) -> f64 {
        time_s.clamp(self.lo_s[k], self.hi_s[k]) - time_s
    }
}

/// A regular clock and the time of each message on it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RegularClock {
    pub time_s: Vec<f64>,
    pub period_s: f64,
    /// Number of messages that are missing.
    pub lost: i64,
    /// Remaining uncertainty of each time, apart from a common offset [s].
    pub std_s: f64,
}

/// Scatter of the sampling about a regular clock that bounds must allow [s].
const LOOSE_S: f64 = 0.003;
/// Cost of a lost message, as the logarithm of its probability, and of each further one.
const LOSS_COST: f64 = 7.0;
const MORE_COST: f64 = 1.5;
/// Most lost messages in a row that are tried one by one.
const MOST_IN_A_ROW: i64 = 4;
/// Survivors that are kept at each message.
const SURVIVORS: usize = 6;
/// Share by which a phase follows a miss: of a time, by the square of period over scatter; of bounds.
const FOLLOW_TIME: f64 = 0.02;
const FOLLOW_BOUND: f64 = 0.25;
/// Share by which a phase follows the middle of its bounds.
const FOLLOW_CENTRE: f64 = 0.003;
/// A miss costs at most that of so many standard deviations.
const FARTHEST: f64 = 4.0;
/// Length of the windows of the line [s].
const WINDOW_S: f64 = 20.0;
/// A period that differs from a timer's by less than this share is the timer's.
const NOMINAL: f64 = 0.006;
/// Largest misfit of the times, in periods.
const MOST_MISFIT: f64 = 1.5;

/// A hypothesis on the messages so far.
#[derive(Debug, Clone, Copy)]
struct Survivor {
    lost: i64,
    /// Time of the next message, if none is lost [s].
    next_s: f64,
    cost: f64,
    from: usize,
}

impl RegularClock {
    /// Fits the clock; `None` if there is none. `keeps_nominal`: a period near to a round one is that of a timer, and the bounds may drift.
    pub(crate) fn fit(bounds: &Bounds, rhythm: &Rhythm, keeps_nominal: bool) -> Option<Self> {
        let mut period_s = rhythm.period_s;
        let is_bounded = !bounds.bursts.is_empty();
        let std_s = if is_bounded { LOOSE_S } else { rhythm.scatter_s };
        let mut numbers = Vec::new();
        for _ in 0..3 {
            // slower than a lost message shows
            let follow = if is_bounded { FOLLOW_BOUND } else { (FOLLOW_TIME * (period_s / std_s).powi(2)).clamp(0.004, 0.05) };
            numbers = count(bounds, period_s, std_s, follow)?;
            period_s = slope(bounds, &numbers)?;
        }
        let mut time_s = lines(bounds, &numbers, period_s);
        if let Some(timer_s) = nominal(period_s).filter(|_| keeps_nominal)
            && let Some((timer_numbers, timer_times_s)) = timed(bounds, timer_s, std_s)
        {
            (numbers, time_s, period_s) = (timer_numbers, timer_times_s, timer_s);
        }
        let misses: Vec<f64> = (0..bounds.len()).map(|k| bounds.miss_s(k, time_s[k]).abs()).collect();
        let misfit_s = middle(misses)?;
        let lost = numbers.last()? - (bounds.len() as i64 - 1);
        if misfit_s > MOST_MISFIT * rhythm.scatter_s.max(LOOSE_S) || period_s <= 0.0 {
            return None;
        }
        // a lost message is found some messages early or late; the line is as good as the mean of a window
        let in_window = (WINDOW_S / period_s).max(1.0);
        let share_lost = lost as f64 / bounds.len() as f64;
        let std_s =
            if is_bounded { period_s * (0.003 + (5.0 * share_lost).min(1.0) * 0.25).sqrt() } else { 2.0 * std_s / in_window.sqrt() };
        Some(Self { time_s, period_s, lost, std_s })
    }
}

/// The period of a timer near `period_s` [s]: a whole rate, or a whole number of milliseconds.
fn nominal(period_s: f64) -> Option<f64> {
    let by_rate = 1.0 / (1.0 / period_s).round();
    let by_time = (period_s * 1e3).round() * 1e-3;
    [by_rate, by_time].into_iter().filter(|p| *p > 0.0 && p.is_finite()).find(|p| (p / period_s - 1.0).abs() < NOMINAL)
}

/// The numbers and times of the messages of a timer with this period. The bounds may move slowly, as the delay of a queue does: a timer does
/// not. `None` if it does not fit.
fn timed(bounds: &Bounds, timer_s: f64, std_s: f64) -> Option<(Vec<i64>, Vec<f64>)> {
    let numbers = count(bounds, timer_s, std_s, FOLLOW_BOUND)?;
    let lines_s = lines(bounds, &numbers, timer_s);
    let start_s = middle(lines_s.iter().zip(&numbers).map(|(t, n)| t - *n as f64 * timer_s).collect())?;
    let time_s: Vec<f64> = numbers.iter().map(|n| start_s + *n as f64 * timer_s).collect();
    let width_s = middle((0..bounds.len()).map(|k| bounds.hi_s[k] - bounds.lo_s[k]).collect())?;
    let off = (0..bounds.len()).filter(|&k| bounds.miss_s(k, time_s[k]).abs() > width_s).count();
    (off * 10 < bounds.len()).then_some((numbers, time_s))
}

/// The number of each message's period.
fn count(bounds: &Bounds, period_s: f64, std_s: f64, follow: f64) -> Option<Vec<i64>> {
    let mut alive = vec![Survivor { lost: 0, next_s: bounds.centre_s(0), cost: 0.0, from: 0 }];
    let is_bounded = !bounds.bursts.is_empty();
    let mut history: Vec<Vec<(i64, usize)>> = Vec::with_capacity(bounds.len());
    for k in 0..bounds.len() {
        let mut next: Vec<Survivor> = Vec::with_capacity(4 * alive.len());
        for (from, survivor) in alive.iter().enumerate() {
            let far = ((bounds.centre_s(k) - survivor.next_s) / period_s).round() as i64;
            let tried = (0..=MOST_IN_A_ROW).chain((far > MOST_IN_A_ROW).then_some(far)).chain((far - 1 > MOST_IN_A_ROW).then_some(far - 1));
            for skipped in tried {
                let expected_s = survivor.next_s + skipped as f64 * period_s;
                let miss_s = bounds.miss_s(k, expected_s);
                let z = (miss_s / std_s).abs().min(FARTHEST);
                let loss = if skipped > 0 { LOSS_COST + MORE_COST * (skipped.min(20) - 1) as f64 } else { 0.0 };
                // within its bounds, a time is as likely near either end
                let off_s = bounds.centre_s(k) - expected_s;
                let (pull, width_s) = if is_bounded { (FOLLOW_CENTRE, 0.5 * (bounds.hi_s[k] - bounds.lo_s[k])) } else { (0.0, 1.0) };
                let uniform = if is_bounded { off_s / (0.577 * width_s.max(std_s)) } else { 0.0 };
                let moved_s = follow * miss_s.clamp(-3.0 * std_s, 3.0 * std_s) + pull * off_s.clamp(-width_s, width_s);
                next.push(Survivor {
                    lost: survivor.lost + skipped,
                    next_s: expected_s + moved_s + period_s,
                    cost: survivor.cost + 0.5 * (z * z + uniform.powi(2).min(FARTHEST)) + loss,
                    from,
                });
            }
        }
        next.sort_by(|a, b| a.lost.cmp(&b.lost).then(a.cost.total_cmp(&b.cost)));
        next.dedup_by_key(|s| s.lost);
        next.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        next.truncate(SURVIVORS);
        history.push(next.iter().map(|s| (s.lost, s.from)).collect());
        alive = next;
    }
    let mut at = 0;
    let mut numbers = vec![0; bounds.len()];
    for k in (0..bounds.len()).rev() {
        let (lost, from) = *history[k].get(at)?;
        numbers[k] = k as i64 + lost;
        at = from;
    }
    Some(numbers)
}

/// The period by a robust line through the centres [s].
fn slope(bounds: &Bounds, numbers: &[i64]) -> Option<f64> {
    let half = bounds.len() / 2;
    let pairs = (0..half).map(|k| ((bounds.centre_s(k + half) - bounds.centre_s(k)) / (numbers[k + half] - numbers[k]).max(1) as f64, k));
    middle(pairs.map(|(slope, _)| slope).collect())
}

/// The times on lines that are fitted in overlapping windows.
fn lines(bounds: &Bounds, numbers: &[i64], period_s: f64) -> Vec<f64> {
    let n = bounds.len();
    let per_window = ((WINDOW_S / period_s) as usize).max(50).min(n);
    let step = (per_window / 2).max(1);
    let (mut sums, mut weights) = (vec![0.0; n], vec![0.0; n]);
    let mut from = 0;
    loop {
        let to = (from + per_window).min(n);
        // the last window is as long as the others
        let from_full = to.saturating_sub(per_window);
        let line = line(bounds, numbers, period_s, from_full..to);
        let centre = 0.5 * (from_full + to) as f64;
        for k in from_full..to {
            let weight = 1.0 - 0.98 * ((k as f64 + 0.5 - centre) / (0.5 * (to - from_full) as f64)).abs();
            sums[k] += weight * line(numbers[k]);
            weights[k] += weight;
        }
        if to == n {
            break;
        }
        from += step;
    }
    sums.iter().zip(&weights).map(|(s, w)| s / w).collect()
}

/// The line through the bounds of a range, by Gauss-Newton on the squared misses, with a weak pull to the centres.
fn line(bounds: &Bounds, numbers: &[i64], period_s: f64, range: std::ops::Range<usize>) -> impl Fn(i64) -> f64 {
    const PULL: f64 = 0.01;
    let middle_number = numbers[range.start].midpoint(numbers[range.end - 1]);
    let along = |number: i64| (number - middle_number) as f64;
    let is_exact = bounds.bursts.is_empty();
    // deviations from the period through the middle
    let nominal = |k: usize| period_s * along(numbers[k]);
    let (mut level, mut tilt) = (range.clone().map(|k| bounds.centre_s(k) - nominal(k)).sum::<f64>() / range.len() as f64, 0.0);
    for _ in 0..if is_exact { 4 } else { 20 } {
        let (mut a, mut b) = ([[0.0; 2]; 2], [0.0; 2]);
        for k in range.clone() {
            let x = along(numbers[k]);
            let at = level + tilt * x + nominal(k);
            let miss = bounds.miss_s(k, at);
            let robust = if is_exact { 1.0 } else { f64::from(miss != 0.0) };
            let pull = if is_exact { 0.0 } else { PULL };
            let toward = bounds.centre_s(k) - at;
            let (weight, residual) = (robust + pull, robust * miss + pull * toward);
            a[0][0] += weight;
            a[0][1] += weight * x;
            a[1][1] += weight * x * x;
            b[0] += residual;
            b[1] += residual * x;
        }
        let determinant = a[0][0] * a[1][1] - a[0][1] * a[0][1];
        if determinant <= 0.0 {
            break;
        }
        level += (b[0] * a[1][1] - b[1] * a[0][1]) / determinant;
        tilt += (b[1] * a[0][0] - b[0] * a[0][1]) / determinant;
    }
    move |number| level + (tilt + period_s) * (number - middle_number) as f64
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Messages every 20 ms, some lost, with a deterministic scatter between −1 and 1.
    fn sampled() -> Vec<(f64, f64)> {
        (0..5000u64).filter(|k| k % 211 != 40).map(|k| (k as f64 * 0.02, ((k * 7919 + k * k * 31) % 2003) as f64 / 1001.0 - 1.0)).collect()
    }

    /// Errors of the fitted times apart from their median, sorted by size [s].
    fn errors(clock: &RegularClock, truth: &[(f64, f64)]) -> Vec<f64> {
        let apart: Vec<f64> = clock.time_s.iter().zip(truth).map(|(t, (wanted, _))| t - wanted).collect();
        let centre = middle(apart.clone()).unwrap();
        let mut sizes: Vec<f64> = apart.iter().map(|a| (a - centre).abs()).collect();
        sizes.sort_unstable_by(f64::total_cmp);
        sizes
    }

    #[test]
    fn times_that_scatter_by_a_period_are_numbered_and_fitted() {
        let truth = sampled();
        let times: Vec<f64> = truth.iter().map(|(t, scatter)| t + 0.02 * scatter).collect();
        let rhythm = Rhythm::of(&times).unwrap();
        let clock = RegularClock::fit(&Bounds::exact(&times), &rhythm, false).unwrap();
        assert!((24..=25).contains(&clock.lost), "{}", clock.lost);
        let errors = errors(&clock, &truth);
        assert!((clock.period_s - 0.02).abs() < 1e-5 && errors[errors.len() * 9 / 10] < 0.002, "{}", errors[errors.len() * 9 / 10]);
    }

    #[test]
    fn messages_in_bursts_are_spread_over_the_time_since_the_last_burst() {
        let truth = sampled();
        let times: Vec<f64> = truth.iter().map(|(t, scatter)| ((t + 0.002 * scatter) / 0.1003).ceil() * 0.1003).collect();
        let rhythm = Rhythm::of(&times).unwrap();
        assert!(rhythm.comes_in_bursts);
        let clock = RegularClock::fit(&Bounds::of_bursts(&times, 0.006), &rhythm, true).unwrap();
        let errors = errors(&clock, &truth);
        assert!(errors[errors.len() * 9 / 10] < 0.006, "{} lost, {}", clock.lost, errors[errors.len() * 9 / 10]);
        assert!((clock.period_s - 0.02).abs() < 1e-12);
    }

    #[test]
    fn stamps_that_go_back_within_a_burst_and_behind_the_one_before_keep_their_bounds_in_order() {
        let truth = sampled();
        let mut times: Vec<f64> = truth.iter().map(|(t, scatter)| ((t + 0.002 * scatter) / 0.1003).ceil() * 0.1003).collect();
        for k in (7..times.len()).step_by(29) {
            times[k] -= 0.11;
        }
        let bounds = Bounds::of_bursts(&times, 0.006);
        assert!(bounds.lo_s.iter().zip(&bounds.hi_s).all(|(lo, hi)| lo <= hi));
        RegularClock::fit(&bounds, &Rhythm::of(&times).unwrap(), true);
    }
}
