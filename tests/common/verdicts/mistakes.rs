//! The mistakes, each in two strengths: what a campaign, a log, a signal map or a command line can have wrong.

mod campaigns;
mod clocks;
mod drives;
mod geometry;
mod settings;
mod signals;
mod units;

use crate::verdicts::Fallible;
use crate::verdicts::case::Case;

/// What a mistake does to a good case, with its strength.
pub(crate) type Apply = fn(&mut Case, f64) -> Fallible<()>;

/// One mistake in one strength.
#[derive(Clone, Copy)]
pub(crate) struct Mistake {
    /// Its kind.
    pub(crate) kind: &'static str,
    /// Its strength, for a reader.
    pub(crate) strength: &'static str,
    /// Why no data can show it; `None` for what can be seen.
    pub(crate) hidden: Option<&'static str>,
    value: f64,
    apply: Apply,
}

impl Mistake {
    /// A good case with this mistake.
    ///
    /// # Errors
    /// What the simulator refuses.
    pub(crate) fn made(&self, vehicle: &str, seed: u64) -> Fallible<Case> {
        let mut case = Case::good(vehicle, seed)?;
        (self.apply)(&mut case, self.value)?;
        Ok(case)
    }
}

/// A kind that can be seen.
fn kind<const N: usize>(kind: &'static str, strengths: [(&'static str, f64); N], apply: Apply) -> Vec<Mistake> {
    strengths.into_iter().map(|(strength, value)| Mistake { kind, strength, hidden: None, value, apply }).collect()
}

/// A kind that no data can show.
fn hidden<const N: usize>(name: &'static str, strengths: [(&'static str, f64); N], why: &'static str, apply: Apply) -> Vec<Mistake> {
    kind(name, strengths, apply).into_iter().map(|mistake| Mistake { hidden: Some(why), ..mistake }).collect()
}

/// All mistakes.
pub(crate) fn all() -> Vec<Mistake> {
    [geometry::all(), units::all(), signals::all(), clocks::all(), drives::all(), campaigns::all(), settings::all()].concat()
}
