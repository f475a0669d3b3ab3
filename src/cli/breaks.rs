//! Axes on the command line: `start:step:stop` or a list.

use anyhow::{bail, ensure};

/// Breaks of an axis in the user's notation.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Breaks(pub(crate) Vec<f64>);

impl std::str::FromStr for Breaks {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let number = |part: &str| {
            part.trim().parse::<f64>().ok().filter(|v| v.is_finite()).ok_or_else(|| anyhow::anyhow!("{:?} is not a number", part.trim()))
        };
        let breaks = if text.contains(':') {
            let parts = text.split(':').map(number).collect::<anyhow::Result<Vec<f64>>>()?;
            let [start, step, stop] = parts[..] else { bail!("a range is start:step:stop, such as 0:0.05:1.1") };
            ensure!(step > 0.0 && stop > start, "a range start:step:stop needs a positive step and a stop above its start");
            ensure!((stop - start) / step < 2000.0, "this range has more than 2000 breaks");
            let count = ((stop - start) / step + 1e-6).floor() as usize;
            (0..=count).map(|k| ((start + k as f64 * step) * 1e9).round() / 1e9).collect()
        } else {
            text.split(',').map(number).collect::<anyhow::Result<Vec<f64>>>()?
        };
        ensure!(breaks.len() >= 2, "an axis needs at least 2 breaks");
        if let Some(k) = (1..breaks.len()).find(|k| breaks[*k] <= breaks[k - 1]) {
            bail!("breaks must increase: {} follows {}", breaks[k], breaks[k - 1]);
        }
        Ok(Self(breaks))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_range_and_a_list_give_the_same_breaks() {
        assert_eq!("0:0.1:0.3".parse::<Breaks>().unwrap(), "0, 0.1, 0.2, 0.3".parse().unwrap());
        assert!("0:0:1".parse::<Breaks>().is_err() && "1,0".parse::<Breaks>().is_err() && "a,b".parse::<Breaks>().is_err());
    }
}
