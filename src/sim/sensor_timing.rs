//! Timing of one sensor: rate, phase, latency, jitter, lost readings, dropouts.

use crate::sim::error::{Error, Result, within};
use crate::sim::random::{Random, Stream};
use serde::{Deserialize, Serialize};

/// Timing and loss of a sensor's readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Timing {
    /// Readings per second. Default 50.
    pub rate_hz: f64,
    /// Time of the first reading [s]. Default: drawn from the seed within one period.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phase_s: Option<f64>,
    /// Time from reading to arrival [s]. Default 0.004.
    pub latency_s: f64,
    /// Standard deviation of the stamp from the true time of the reading [s], limited to ±3 of them. Default 0.0008.
    pub jitter_s: f64,
    /// Offset of the sensor's clock [s], added to every stamp; positive if the clock is ahead. Default 0.
    pub clock_offset_s: f64,
    /// Share of readings that never arrive. Default 0.003.
    pub lost_fraction: f64,
    /// Mean rate of dropouts [1/s]. Default 0.
    pub dropouts_per_s: f64,
    /// Length of a dropout [s]. Default 0.3.
    pub dropout_s: f64,
    /// Readings arrive together, once in this time [s]; 0, the default, for each when it is due.
    pub burst_s: f64,
    /// Stamps are rounded to this step [s]; 0, the default, for none.
    pub stamp_step_s: f64,
    /// Whether the stamp is the time of arrival. Default false.
    pub stamped_on_arrival: bool,
}

impl Default for Timing {
    fn default() -> Self {
        Self {
            rate_hz: 50.0,
            phase_s: None,
            latency_s: 0.004,
            jitter_s: 0.0008,
            clock_offset_s: 0.0,
            lost_fraction: 0.003,
            dropouts_per_s: 0.0,
            dropout_s: 0.3,
            burst_s: 0.0,
            stamp_step_s: 0.0,
            stamped_on_arrival: false,
        }
    }
}

impl Timing {
    /// Exactly `rate_hz`, without latency and without loss.
    pub fn ideal(rate_hz: f64) -> Self {
        Self { rate_hz, phase_s: Some(0.0), latency_s: 0.0, jitter_s: 0.0, lost_fraction: 0.0, ..Self::default() }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first field that is out of its range, or a latency of more than [`KEPT`] periods.
    pub fn check(&self) -> Result<()> {
        within("timing.rate_hz", self.rate_hz, 0.1..=1000.0, "0.1 to 1000")?;
        within("timing.phase_s", self.phase_s.unwrap_or(0.0), 0.0..=10.0, "0 to 10")?;
        within("timing.latency_s", self.latency_s, 0.0..=10.0, "0 to 10")?;
        within("timing.jitter_s", self.jitter_s, 0.0..=0.1, "0 to 0.1")?;
        within("timing.clock_offset_s", self.clock_offset_s, -3600.0..=3600.0, "-3600 to 3600")?;
        within("timing.lost_fraction", self.lost_fraction, 0.0..=0.99, "0 to 0.99")?;
        within("timing.dropouts_per_s", self.dropouts_per_s, 0.0..=10.0, "0 to 10")?;
        within("timing.dropout_s", self.dropout_s, 0.0..=1000.0, "0 to 1000")?;
        within("timing.burst_s", self.burst_s, 0.0..=10.0, "0 to 10")?;
        within("timing.stamp_step_s", self.stamp_step_s, 0.0..=10.0, "0 to 10")?;
        let needed = ((self.latency_s + self.burst_s) * self.rate_hz).ceil() as usize + 1;
        if needed > KEPT { Err(Error::LatencyTooLong { field: "timing.latency_s", needed, most: KEPT }) } else { Ok(()) }
    }
}

/// Largest number of readings in transit.
pub(crate) const KEPT: usize = 16;

/// One reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorReading<T> {
    /// True time of the reading [s].
    pub t_s: f64,
    /// Its stamp [s].
    pub stamp_s: f64,
    /// True time of arrival [s].
    pub arrival_s: f64,
    /// The measured value.
    pub value: T,
}

/// One sensor's readings over time.
#[derive(Debug, Clone)]
pub struct Channel<T> {
    timing: Timing,
    random: Random,
    first_s: f64,
    period_s: f64,
    count: u64,
    next_s: f64,
    dropout_until_s: f64,
    underway: [Option<SensorReading<T>>; KEPT],
    oldest: usize,
    newest: usize,
    arrived: T,
    taken: Option<SensorReading<T>>,
}

impl<T: Copy> Channel<T> {
    /// A channel with the value `initial` until the first reading arrives.
    ///
    /// # Errors
    /// The timing is out of its range.
    pub fn new(timing: &Timing, seed: u64, stream: Stream, initial: T) -> Result<Self> {
        timing.check()?;
        let mut random = Random::new(seed, stream);
        let period_s = 1.0 / timing.rate_hz;
        // drawn even if it is given, so that a fixed phase does not change other draws
        let drawn_s = random.uniform() * period_s;
        let first_s = timing.phase_s.unwrap_or(drawn_s);
        Ok(Self {
            timing: *timing,
            random,
            first_s,
            period_s,
            count: 0,
            next_s: first_s,
            dropout_until_s: f64::NEG_INFINITY,
            underway: [None; KEPT],
            oldest: 0,
            newest: 0,
            arrived: initial,
            taken: None,
        })
    }

    /// The latest value that has arrived by `now_s`, not earlier than the last [`Channel::poll`].
    pub fn latest(&self, now_s: f64) -> T {
        let mut latest = self.arrived;
        for k in 0..KEPT {
            match &self.underway[(self.oldest + k) % KEPT] {
                Some(reading) if reading.arrival_s <= now_s => latest = reading.value,
                _ => break,
            }
        }
        latest
    }

    /// The reading of the last [`Channel::poll`], if there is one and it was not lost.
    pub fn taken(&self) -> Option<&SensorReading<T>> {
        self.taken.as_ref()
    }

    /// Clears [`Channel::taken`].
    pub(crate) fn forget_taken(&mut self) {
        self.taken = None;
    }

    /// Stops the readings.
    pub(crate) fn silence(&mut self) {
        self.next_s = f64::INFINITY;
    }

    /// Time between readings [s].
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// The next time at which [`Channel::poll`] has work to do [s].
    #[inline]
    pub fn next_event_s(&self) -> f64 {
        self.next_s
    }

    /// Advances the channel to `now_s` and takes the due readings; `sample` returns the value at the exact time.
    #[inline]
    pub fn poll(&mut self, now_s: f64, sample: impl FnMut(f64, &mut Random) -> T) {
        self.taken = None;
        if self.next_s <= now_s {
            self.take(now_s, sample);
        }
    }

    fn take(&mut self, now_s: f64, mut sample: impl FnMut(f64, &mut Random) -> T) {
        while let Some(reading) = self.underway[self.oldest].filter(|r| r.arrival_s <= now_s) {
            self.arrived = reading.value;
            self.underway[self.oldest] = None;
            self.oldest = (self.oldest + 1) % KEPT;
        }
        while self.next_s <= now_s {
            let t_s = self.next_s;
            self.count += 1;
            self.next_s = self.first_s + self.count as f64 * self.period_s;
            let value = sample(t_s, &mut self.random);
            let jitter_s = if self.timing.jitter_s > 0.0 { self.timing.jitter_s * self.random.normal().clamp(-3.0, 3.0) } else { 0.0 };
            if self.is_lost(t_s) {
                continue;
            }
            let arrival_s = up_to_step(t_s + self.timing.latency_s, self.timing.burst_s);
            let taken_s = if self.timing.stamped_on_arrival { arrival_s } else { t_s };
            let stamp_s = to_step(taken_s + self.timing.clock_offset_s + jitter_s, self.timing.stamp_step_s);
            let reading = SensorReading { t_s, stamp_s, arrival_s, value };
            self.taken = Some(reading);
            self.underway[self.newest] = Some(reading);
            self.newest = (self.newest + 1) % KEPT;
        }
    }

    fn is_lost(&mut self, t_s: f64) -> bool {
        let timing = &self.timing;
        if timing.dropouts_per_s > 0.0 && self.random.uniform() < timing.dropouts_per_s * self.period_s {
            self.dropout_until_s = t_s + timing.dropout_s;
        }
        let lost = timing.lost_fraction > 0.0 && self.random.uniform() < timing.lost_fraction;
        lost || t_s < self.dropout_until_s
    }
}

/// The next multiple of a step; the value itself where there is no step.
fn up_to_step(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).ceil() * step } else { value }
}

/// The nearest multiple of a step; the value itself where there is no step.
fn to_step(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn channel(timing: &Timing) -> Channel<f64> {
        Channel::new(timing, 3, Stream::Gyro, -1.0).unwrap()
    }

    #[test]
    fn a_reading_is_the_value_at_its_due_time_and_arrives_after_the_latency() {
        let mut channel = channel(&Timing { phase_s: Some(0.0105), latency_s: 0.03, ..Timing::ideal(50.0) });
        let mut seen = Vec::new();
        for k in 0..100 {
            let now_s = f64::from(k) * 1e-3;
            channel.poll(now_s, |t_s, _| t_s);
            if let Some(reading) = channel.taken() {
                seen.push(reading.value);
            }
            if now_s < 0.0405 {
                assert_eq!(channel.latest(now_s), -1.0, "nothing has arrived at {now_s} s");
            }
        }
        assert_eq!(seen.len(), 5);
        assert!((seen[1] - 0.0305).abs() < 1e-12);
        assert!((channel.latest(0.099) - 0.0505).abs() < 1e-12);
    }

    #[test]
    fn lost_readings_and_dropouts_have_the_given_share() {
        let mut channel = channel(&Timing { lost_fraction: 0.1, dropouts_per_s: 0.1, dropout_s: 0.5, ..Timing::ideal(100.0) });
        let mut kept = 0;
        for k in 0..100_000 {
            channel.poll(f64::from(k) * 0.01, |_, _| 0.0);
            kept += i32::from(channel.taken().is_some());
        }
        // 90 % of the share 1/(1 + 0.1·0.5) to exp(−0.05) that remains; the counting error is below 0.5 %
        let share = f64::from(kept) / 1e5;
        assert!((share - 0.9 * 0.953).abs() < 0.01, "{share}");
    }

    #[test]
    fn a_burst_delivers_together_and_a_rounded_stamp_stands_still() {
        let timing = Timing { burst_s: 0.1, stamp_step_s: 0.05, phase_s: Some(0.013), latency_s: 0.001, ..Timing::ideal(50.0) };
        let mut channel = channel(&timing);
        let mut seen: Vec<SensorReading<f64>> = Vec::new();
        for k in 0..200 {
            channel.poll(f64::from(k) * 1e-3, |t_s, _| t_s);
            seen.extend(channel.taken());
        }
        assert!(seen[..5].iter().all(|r| (r.arrival_s - 0.1).abs() < 1e-12) && (seen[5].arrival_s - 0.2).abs() < 1e-12, "{seen:?}");
        assert!((seen[0].stamp_s).abs() < 1e-12 && (seen[1].stamp_s - 0.05).abs() < 1e-12 && (seen[2].stamp_s - 0.05).abs() < 1e-12);
        let arrived = Timing { stamped_on_arrival: true, ..timing };
        let mut channel = Channel::new(&arrived, 3, Stream::Gyro, -1.0).unwrap();
        channel.poll(0.02, |t_s, _| t_s);
        assert!((channel.taken().unwrap().stamp_s - 0.1).abs() < 1e-12);
    }

    #[test]
    fn a_latency_of_too_many_periods_is_refused() {
        let error = Channel::new(&Timing { latency_s: 1.0, ..Timing::ideal(100.0) }, 1, Stream::Gyro, 0.0).unwrap_err();
        assert!(error.to_string().contains("101"), "{error}");
    }
}
