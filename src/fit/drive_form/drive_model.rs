//! The models of a drive between the command after its dead time and the effective torque.
//!
//! Every parameter is a time, so that estimates, steps and bounds are comparable: a time constant, the time in which a ramp crosses a
//! reference torque, the reciprocal of a natural frequency. With c the delayed command and u the torque:
//!
//! - first order: T_c·u̇ = c − u;
//! - rate limit: r follows c at no more than a slope s = u_ref/T_r, and T_c·u̇ = r − u; with two slopes, one while |r| grows and one while it
//!   falls, or one up and one down;
//! - second order: T₀²·ü + T₁·u̇ + u = c, with ω₀ = 1/T₀ and damping ζ = T₁/(2·T₀).

use crate::fit::drive_form::parameters::{LIMIT, PARAMETERS};
use crate::fit::drive_form::torque_limit::TorqueLimit;
use crate::map::{DriveFamily, DriveLimit, IdentifiedDrive, LimitKind};
use std::f64::consts::TAU;
use std::fmt;

/// Longest lag [s].
const LONGEST_LAG_S: f64 = 0.3;
/// Shortest and longest time in which a ramp crosses the reference torque [s].
const RAMP_S: (f64, f64) = (0.01, 8.0);
/// Shortest and longest T₀ [s]: 30 Hz to 0.5 Hz.
const NATURAL_S: (f64, f64) = (0.005, 0.3);
/// Least and most damping ζ.
const DAMPING: (f64, f64) = (0.02, 2.0);

/// The kind of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DriveKind {
    /// A first-order lag. Parameter: T_c.
    FirstOrder,
    /// A rate limit, then a lag. Parameters: T_r, T_c.
    RateLimit,
    /// A rate limit with one slope while the torque's magnitude grows and one while it falls, then a lag. Parameters: both T_r, T_c.
    GrowingFalling,
    /// A rate limit with one slope up and one down, then a lag. Parameters: both T_r, T_c.
    UpDown,
    /// A second-order lag. Parameters: T₀, T₁.
    SecondOrder,
}

impl DriveKind {
    /// Every kind, in the order in which they are tried.
    pub(crate) const ALL: [Self; 5] = [Self::FirstOrder, Self::SecondOrder, Self::RateLimit, Self::GrowingFalling, Self::UpDown];

    /// The kinds of a family, the simplest first.
    pub(crate) fn of(family: DriveFamily) -> Vec<Self> {
        match family {
            DriveFamily::FirstOrder | DriveFamily::Feedback => vec![Self::FirstOrder],
            DriveFamily::RateLimit => vec![Self::RateLimit, Self::GrowingFalling, Self::UpDown],
            DriveFamily::SecondOrder => vec![Self::SecondOrder],
        }
    }

    /// Its family.
    pub(crate) fn family(self) -> DriveFamily {
        match self {
            Self::FirstOrder => DriveFamily::FirstOrder,
            Self::RateLimit | Self::GrowingFalling | Self::UpDown => DriveFamily::RateLimit,
            Self::SecondOrder => DriveFamily::SecondOrder,
        }
    }

    /// Number of its times.
    fn parameters(self) -> usize {
        match self {
            Self::FirstOrder => 1,
            Self::RateLimit | Self::SecondOrder => 2,
            Self::GrowingFalling | Self::UpDown => 3,
        }
    }
}

/// A drive with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DriveModel {
    pub(crate) kind: DriveKind,
    /// Its times [s]; those beyond the kind's own are 0.
    pub(crate) times_s: [f64; 3],
    /// u_ref, the torque whose ramps take T_r [N·m].
    pub(crate) reference_nm: f64,
    /// The limit of the torque that the drive delivers.
    pub(crate) limit: TorqueLimit,
}

impl DriveModel {
    /// A first-order lag [s].
    pub(crate) fn first_order(lag_s: f64) -> Self {
        Self::of_kind(DriveKind::FirstOrder, 1.0).with([lag_s, 0.0, 0.0])
    }

    /// A drive of a kind with its shortest times, without a limit; ramps cross `reference_nm`.
    pub(crate) fn of_kind(kind: DriveKind, reference_nm: f64) -> Self {
        Self { kind, times_s: [0.0; 3], reference_nm, limit: TorqueLimit::None }.with([0.0; 3])
    }

    /// Its parameters: the times [s], and the logarithm of the limit.
    pub(crate) fn parameters(&self) -> [f64; PARAMETERS] {
        let [a, b, c] = self.times_s;
        [a, b, c, self.limit.logarithm()]
    }

    /// Which of the parameters it has.
    pub(crate) fn has(&self) -> [bool; PARAMETERS] {
        let times = self.kind.parameters();
        std::array::from_fn(|p| if p == LIMIT { self.limit != TorqueLimit::None } else { p < times })
    }

    /// The same drive after a step of its parameters, each within its bounds.
    pub(crate) fn moved(self, [a, b, c, limit]: [f64; PARAMETERS]) -> Self {
        let [a0, b0, c0] = self.times_s;
        Self { limit: self.limit.scaled(limit.exp()), ..self.with([a0 + a, b0 + b, c0 + c]) }
    }

    /// The same drive with other times, each within its bounds.
    pub(crate) fn with(self, times_s: [f64; 3]) -> Self {
        let [a, b, c] = times_s;
        let (lag, ramp) = (|t: f64| t.clamp(0.0, LONGEST_LAG_S), |t: f64| t.clamp(RAMP_S.0, RAMP_S.1));
        let times_s = match self.kind {
            DriveKind::FirstOrder => [lag(a), 0.0, 0.0],
            DriveKind::RateLimit => [ramp(a), lag(b), 0.0],
            DriveKind::GrowingFalling | DriveKind::UpDown => [ramp(a), ramp(b), lag(c)],
            DriveKind::SecondOrder => {
                let natural = a.clamp(NATURAL_S.0, NATURAL_S.1);
                [natural, b.clamp(2.0 * DAMPING.0 * natural, 2.0 * DAMPING.1 * natural), 0.0]
            }
        };
        Self { times_s, ..self }
    }

    /// The area between a full step and its response over the step: the lag of the nearest first-order drive [s].
    pub(crate) fn mean_lag_s(&self) -> f64 {
        let [a, b, c] = self.times_s;
        match self.kind {
            DriveKind::FirstOrder => a,
            DriveKind::RateLimit => 0.5 * a + b,
            DriveKind::GrowingFalling | DriveKind::UpDown => 0.25 * (a + b) + c,
            DriveKind::SecondOrder => b,
        }
    }

    /// Standard error of that mean lag by those of the parameters [s].
    pub(crate) fn mean_lag_std_err_s(&self, [a, b, c, _]: [f64; PARAMETERS]) -> f64 {
        match self.kind {
            DriveKind::FirstOrder => a,
            DriveKind::RateLimit => (0.5 * a).hypot(b),
            DriveKind::GrowingFalling | DriveKind::UpDown => (0.25 * a).hypot(0.25 * b).hypot(c),
            DriveKind::SecondOrder => b,
        }
    }

    /// The same drive with a mean lag that is longer by `by_s` [s].
    pub(crate) fn later(self, by_s: f64) -> Self {
        let [a, b, c] = self.times_s;
        self.with(match self.kind {
            DriveKind::FirstOrder => [a + by_s, b, c],
            DriveKind::RateLimit => [a + 2.0 * by_s, b, c],
            DriveKind::GrowingFalling | DriveKind::UpDown => [a + 2.0 * by_s, b + 2.0 * by_s, c],
            DriveKind::SecondOrder => [a, b + by_s, c],
        })
    }

    /// Slopes of a rate limit [N·m/s]: growing (or up) and falling (or down). `None` for another drive.
    pub(crate) fn slopes_nm_s(&self) -> Option<[f64; 2]> {
        let [a, b, _] = self.times_s;
        match self.kind {
            DriveKind::RateLimit => Some([self.reference_nm / a; 2]),
            DriveKind::GrowingFalling | DriveKind::UpDown => Some([self.reference_nm / a, self.reference_nm / b]),
            DriveKind::FirstOrder | DriveKind::SecondOrder => None,
        }
    }

    /// The lag after a rate limit, or the lag of a first-order drive [s]; 0 for a second-order one.
    pub(crate) fn lag_s(&self) -> f64 {
        match self.kind {
            DriveKind::FirstOrder => self.times_s[0],
            DriveKind::RateLimit => self.times_s[1],
            DriveKind::GrowingFalling | DriveKind::UpDown => self.times_s[2],
            DriveKind::SecondOrder => 0.0,
        }
    }

    /// Natural frequency [Hz] and damping of a second-order drive. `None` for another drive.
    pub(crate) fn frequency_hz_and_damping(&self) -> Option<(f64, f64)> {
        let [natural, damped, _] = self.times_s;
        (self.kind == DriveKind::SecondOrder).then(|| (1.0 / (TAU * natural), damped / (2.0 * natural)))
    }
}

impl DriveModel {
    /// The drive for the file; `limit_std_err` is the standard error of the logarithm of a power limit.
    pub(crate) fn identified(&self, limit_std_err: f64) -> IdentifiedDrive {
        let rounded = |x: f64| (x * 1e6).round() / 1e6;
        let resonance = self.frequency_hz_and_damping();
        IdentifiedDrive {
            family: self.kind.family(),
            lag_s: (self.kind != DriveKind::SecondOrder).then(|| rounded(self.lag_s())),
            slopes_nm_s: self.slopes_nm_s().map(|slopes| slopes.map(rounded)),
            slopes_by_magnitude: self.kind == DriveKind::GrowingFalling,
            frequency_hz: resonance.map(|r| rounded(r.0)),
            damping: resonance.map(|r| rounded(r.1)),
            limit: match self.limit {
                TorqueLimit::None => None,
                TorqueLimit::Torque(value) => Some(DriveLimit { kind: LimitKind::Torque, value: rounded(value), std_err: None }),
                TorqueLimit::Power(value) => {
                    Some(DriveLimit { kind: LimitKind::Power, value: rounded(value), std_err: Some(rounded(value * limit_std_err)) })
                }
            },
            undelivered_s: None,
            undelivered_share: None,
            exceeded_s: None,
            better_than_given: None,
            compared: Vec::new(),
        }
    }
}

impl fmt::Display for DriveModel {
    /// In words, with the parameters.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.kind, self.slopes_nm_s(), self.frequency_hz_and_damping()) {
            (DriveKind::GrowingFalling, Some([a, b]), _) => write!(f, "rate limit of {a:.0} N·m/s growing and {b:.0} N·m/s falling")?,
            (DriveKind::UpDown, Some([a, b]), _) => write!(f, "rate limit of {a:.0} N·m/s up and {b:.0} N·m/s down")?,
            (_, Some([a, _]), _) => write!(f, "rate limit of {a:.0} N·m/s")?,
            (_, _, Some((hz, damping))) => write!(f, "second-order lag of {hz:.1} Hz with damping {damping:.2}")?,
            _ => write!(f, "first-order lag of {:.0} ms", 1e3 * self.lag_s())?,
        }
        match self.limit {
            TorqueLimit::None => Ok(()),
            TorqueLimit::Torque(nm) => write!(f, ", limited to {nm:.1} N·m"),
            TorqueLimit::Power(power) => write!(f, ", limited to {power:.1} N·m·m/s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_stay_within_their_bounds_and_convert_to_the_usual_figures() {
        let drive = DriveModel::of_kind(DriveKind::SecondOrder, 20.0);
        let resonant = drive.with([1.0 / (TAU * 6.0), 0.4 / (TAU * 6.0), 1.0]);
        let (hz, damping) = resonant.frequency_hz_and_damping().unwrap_or((0.0, 0.0));
        assert!((hz - 6.0).abs() < 1e-9 && (damping - 0.2).abs() < 1e-9 && resonant.times_s[2] == 0.0);
        assert!(drive.with([-1.0, -1.0, 0.0]).times_s[1] > 0.0);
        let ramp = DriveModel { kind: DriveKind::RateLimit, ..drive }.with([0.5, 0.02, 0.0]);
        assert_eq!(ramp.slopes_nm_s(), Some([40.0; 2]));
        assert!((ramp.mean_lag_s() - 0.27).abs() < 1e-12);
    }
}
