//! The time at which a value was true: the stamp inside the message, if it has one.

use crate::log::extract::extractor::Extractor;
use crate::log::extract::extractor::taken::Taken;
use crate::log::path::{MessagePath, PathStep};
use crate::log::schema::Layout;
use crate::log::signal_map::Stamp;
use crate::log::value::Raw;

/// Slots that together hold a stamp.
#[derive(Debug, Clone, Copy)]
pub(crate) enum StampPath {
    /// Seconds and nanoseconds in separate fields.
    Parts { seconds: usize, nanoseconds: usize },
    /// One number; its magnitude determines its unit.
    Single(usize),
}

/// Names of the whole seconds of a stamp.
pub(crate) const SECONDS: [&str; 3] = ["sec", "seconds", "secs"];
/// Names of its nanoseconds.
pub(crate) const NANOSECONDS: [&str; 5] = ["nanosec", "nanos", "nsec", "nsecs", "nanoseconds"];
/// Where a stamp is searched for when the signal map names none.
const PLACES: [&[&str]; 3] = [&["header", "stamp"], &["stamp"], &["header", "timestamp"]];

/// The paths to the parts of a stamp in messages of this layout. `sample` is a payload, tried for layouts without a schema.
pub(crate) fn find(layout: &Layout, stamp: &Stamp, sample: Option<&[u8]>) -> Option<Vec<Vec<PathStep>>> {
    let places: Vec<Vec<PathStep>> = match stamp {
        Stamp::None => return None,
        Stamp::At(place) => vec![place.clone()],
        Stamp::Usual => PLACES.iter().map(|names| names.iter().map(|name| PathStep::Field((*name).to_owned())).collect()).collect(),
    };
    places.into_iter().find_map(|place| {
        let child = |name: &&str| [place.clone(), vec![PathStep::Field((*name).to_owned())]].concat();
        let parts = SECONDS.iter().find(|name| holds(layout, &child(name), sample)).and_then(|seconds| {
            let nanoseconds = NANOSECONDS.iter().find(|name| holds(layout, &child(name), sample))?;
            Some(vec![child(seconds), child(nanoseconds)])
        });
        parts.or_else(|| holds(layout, &place, sample).then(|| vec![place.clone()]))
    })
}

fn holds(layout: &Layout, steps: &[PathStep], sample: Option<&[u8]>) -> bool {
    !MessagePath::inside(steps.to_vec()).is_list() && Extractor::leads(layout, steps, sample, |raw| number(raw).is_some())
}

impl StampPath {
    /// The stamp [ns since its epoch]; `None` if the message holds no stamp or zero. Drivers without a clock write zero.
    pub(crate) fn time_ns(self, taken: &Taken<'_>) -> Option<i64> {
        let time = match self {
            Self::Parts { seconds, nanoseconds } => {
                let whole = integer(taken.get(seconds))?.checked_mul(1_000_000_000)?;
                whole.checked_add(integer(taken.get(nanoseconds)).unwrap_or(0))?
            }
            Self::Single(slot) => match number(taken.get(slot))? {
                // a date of this century in nanoseconds, microseconds, milliseconds or seconds
                value if value.abs() >= 1e17 => integer(taken.get(slot))?,
                value if value.abs() >= 1e14 => (value * 1e3) as i64,
                value if value.abs() >= 1e11 => (value * 1e6) as i64,
                value => (value * 1e9) as i64,
            },
        };
        (time > 0).then_some(time)
    }
}

fn integer(raw: &Raw<'_>) -> Option<i64> {
    match raw {
        Raw::Integer(value) => Some(*value),
        Raw::Number(value) if value.is_finite() => Some(*value as i64),
        Raw::Text(text) => text.trim().parse().ok(),
        Raw::Number(_) | Raw::Missing => None,
    }
}

fn number(raw: &Raw<'_>) -> Option<f64> {
    match raw {
        Raw::Integer(value) => Some(*value as f64),
        Raw::Number(value) => value.is_finite().then_some(*value),
        Raw::Text(text) => text.trim().parse().ok().filter(|value: &f64| value.is_finite()),
        Raw::Missing => None,
    }
}
