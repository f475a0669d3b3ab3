//! How the motion of the vehicle responds to its torque: after which time, how well, and with which sign.
//!
//! The acceleration is regressed on the earlier torque, and on the direction of travel, the speed and a constant, which represent
//! friction: a(t) ≈ β·u(t − lag) + β₁·sgn v + β₂·v + β₃. The share of the rest that the torque explains is largest at the true lag. A
//! vehicle responds within some tenths of a second, so another lag is that of two clocks.

use crate::signal::Series;

/// Half of the window over which an acceleration is measured [s].
const HALF_WINDOW_S: f64 = 0.1;
/// A wheel that turns slower may be about to stop [m/s].
const MOVING_MPS: f64 = 0.05;
/// Least time in motion that shows a lag or a sign [s].
const LEAST_MOTION_S: f64 = 12.0;
/// Most points that are compared, and fewest.
const MOST_POINTS: usize = 3000;
const FEWEST_POINTS: usize = 100;
/// Step of the held torque's integral [s].
const GRID_S: f64 = 0.02;

/// A response at one lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Answer {
    /// Lag of the motion behind the torque [s].
    pub lag_s: f64,
    /// Share of the acceleration that the torque explains, beyond friction: 0 to 1.
    pub explained: f64,
    /// Whether a higher torque accelerates in the positive direction.
    pub is_positive: bool,
}

/// The accelerations of a wheel, ready to be compared with a torque.
#[derive(Debug, Clone)]
pub(crate) struct Accelerations {
    t_s: Vec<f64>,
    /// Acceleration less its part along the basis, with its squared length.
    rest: Vec<f64>,
    rest2: f64,
    /// Orthonormal: constant, direction of travel, speed.
    basis: Vec<Vec<f64>>,
}

impl Accelerations {
    /// From a speed [m/s]; `None` if the wheel moves too little.
    pub(crate) fn of(speed: &Series) -> Option<Self> {
        let slopes = speed.slopes(HALF_WINDOW_S);
        let moving: Vec<usize> = (0..speed.len()).filter(|&k| speed.value[k].abs() > MOVING_MPS).collect();
        // a few runs agree with any lag
        let moving_s = moving.len() as f64 * speed.median_period_s().min(1.0);
        if moving.len() < FEWEST_POINTS || moving_s < LEAST_MOTION_S {
            return None;
        }
        let points: Vec<usize> = moving.iter().copied().step_by(moving.len().div_ceil(MOST_POINTS)).collect();
        let mut basis: Vec<Vec<f64>> = Vec::new();
        let columns: [&dyn Fn(usize) -> f64; 3] = [&|_| 1.0, &|k| speed.value[k].signum(), &|k| speed.value[k]];
        for column in columns {
            let mut vector: Vec<f64> = points.iter().map(|&k| column(k)).collect();
            let before = dot(&vector, &vector);
            for known in &basis {
                remove(&mut vector, known);
            }
            let length2 = dot(&vector, &vector);
            if length2 > 1e-6 * before {
                for v in &mut vector {
                    *v /= length2.sqrt();
                }
                basis.push(vector);
            }
        }
        let mut rest: Vec<f64> = points.iter().map(|&k| slopes[k]).collect();
        for known in &basis {
            remove(&mut rest, known);
        }
        let rest2 = dot(&rest, &rest);
        (rest2 > 0.0).then(|| Self { t_s: points.iter().map(|&k| speed.t_s[k]).collect(), rest, rest2, basis })
    }

    /// The response to a torque at a lag [s].
    pub(crate) fn answer(&self, torque: &HeldMeans, lag_s: f64) -> Answer {
        let u: Vec<f64> = self.t_s.iter().map(|t| torque.mean(t - lag_s)).collect();
        let along: f64 = self.basis.iter().map(|q| dot(q, &u).powi(2)).sum();
        let u2 = dot(&u, &u) - along;
        let product = dot(&u, &self.rest);
        let explained = if u2 > 1e-9 * (along + u2) { product * product / (u2 * self.rest2) } else { 0.0 };
        Answer { lag_s, explained, is_positive: product >= 0.0 }
    }

    /// The best response among lags from `from_s` to `to_s` in steps.
    pub(crate) fn best(&self, torque: &HeldMeans, from_s: f64, to_s: f64, step_s: f64) -> Answer {
        let count = ((to_s - from_s) / step_s).round() as usize;
        let answers = (0..=count).map(|k| self.answer(torque, from_s + k as f64 * step_s));
        answers.fold(
            Answer { lag_s: 0.0, explained: 0.0, is_positive: true },
            |best, next| {
                if next.explained > best.explained { next } else { best }
            },
        )
    }
}

/// Means of a held torque over the window of an acceleration.
#[derive(Debug, Clone)]
pub(crate) struct HeldMeans {
    start_s: f64,
    /// Integral from the start to each point of a grid [N·m·s].
    integral: Vec<f64>,
    step_s: f64,
    first: f64,
    last: f64,
}

impl HeldMeans {
    /// From a held series; `None` if it is empty.
    pub(crate) fn of(series: &Series) -> Option<Self> {
        let (start_s, end_s) = (*series.t_s.first()?, *series.t_s.last()?);
        let step_s = GRID_S.max((end_s - start_s) / 1e6);
        let mut cursor = series.cursor();
        let mut integral = vec![0.0];
        for k in 0..((end_s - start_s) / step_s) as usize {
            let value = cursor.held(start_s + (k as f64 + 0.5) * step_s).unwrap_or(0.0);
            integral.push(integral[k] + value * step_s);
        }
        Some(Self { start_s, integral, step_s, first: series.value[0], last: series.value[series.len() - 1] })
    }

    /// Integral up to a time; the first and last values hold beyond the ends.
    fn until(&self, t_s: f64) -> f64 {
        let x = (t_s - self.start_s) / self.step_s;
        let end = self.integral.len() - 1;
        if x <= 0.0 {
            self.first * x * self.step_s
        } else if x >= end as f64 {
            self.integral[end] + self.last * (x - end as f64) * self.step_s
        } else {
            let k = x as usize;
            self.integral[k] + (x - k as f64) * (self.integral[k + 1] - self.integral[k])
        }
    }

    /// Mean around a time.
    pub(crate) fn mean(&self, t_s: f64) -> f64 {
        (self.until(t_s + HALF_WINDOW_S) - self.until(t_s - HALF_WINDOW_S)) / (2.0 * HALF_WINDOW_S)
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Removes the part of `vector` along a unit vector.
fn remove(vector: &mut [f64], along: &[f64]) {
    let part = dot(vector, along);
    vector.iter_mut().zip(along).for_each(|(v, q)| *v -= part * q);
}

#[cfg(test)]
pub(crate) mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A wheel that starts, brakes and stops, driven by the torque `late_s` before, with friction: command and speed.
    pub(crate) fn driven(late_s: f64) -> (Series, Series) {
        const TORQUES_NM: [f64; 11] = [0.0, 14.0, 20.0, 2.0, -6.0, 0.0, -16.0, -22.0, -3.0, 5.0, 0.0];
        let torque = |t: f64| if t < 0.0 { 0.0 } else { TORQUES_NM[(t / 1.7) as usize % 11] };
        let (mut command, mut speed) = (Series::default(), Series::default());
        let mut v = 0.0f64;
        for k in 0..8000 {
            let t = f64::from(k) * 0.01;
            let u = torque(t - late_s);
            let friction = 5.0 * if v == 0.0 { u.clamp(-5.0, 5.0) / 5.0 } else { v.signum() } + 6.0 * v;
            let next = v + 0.01 * 0.05 * (u - friction);
            v = if v * next < 0.0 { 0.0 } else { next };
            speed.t_s.push(t);
            speed.value.push(v + 0.002 * f64::from(k * 7919 % 101 - 50) / 50.0);
            if k % 2 == 0 {
                command.t_s.push(t);
                command.value.push(torque(t));
            }
        }
        (command, speed)
    }

    #[test]
    fn the_lag_and_the_sign_of_a_torque_are_those_of_its_motion() {
        for late_s in [0.1, 1.5, -2.4] {
            let (command, speed) = driven(late_s);
            let motion = Accelerations::of(&speed).unwrap();
            let found = motion.best(&HeldMeans::of(&command).unwrap(), -3.0, 3.0, 0.05);
            assert!((found.lag_s - late_s).abs() < 0.051 && found.explained > 0.8 && found.is_positive, "{late_s}: {found:?}");
            let negative = Series { value: command.value.iter().map(|v| -v).collect(), ..command };
            assert!(!motion.answer(&HeldMeans::of(&negative).unwrap(), late_s).is_positive);
        }
        assert!(Accelerations::of(&Series::default()).is_none());
    }
}
