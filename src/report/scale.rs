//! From values to places and colours.

/// A linear axis from values to pixels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    pub(crate) low: f64,
    pub(crate) high: f64,
    from_px: f64,
    to_px: f64,
}

impl Scale {
    /// `low` is drawn at `from_px`, `high` at `to_px`. An empty range is widened.
    pub(crate) fn new(low: f64, high: f64, from_px: f64, to_px: f64) -> Self {
        let high = if high > low { high } else { low + 1.0 };
        Self { low, high, from_px, to_px }
    }

    /// An axis over `values` that ends on round numbers and contains zero if `with_zero`.
    pub(crate) fn over(values: impl Iterator<Item = f64>, with_zero: bool, from_px: f64, to_px: f64) -> Self {
        let start = if with_zero { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
        let (low, high) = values.filter(|v| v.is_finite()).fold(start, |(a, b), v| (a.min(v), b.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let step = round_step((high - low).max(1e-9), 5.0);
        Self::new((low / step + 1e-9).floor() * step, (high / step - 1e-9).ceil() * step, from_px, to_px)
    }

    /// The place of a value.
    pub(crate) fn at(&self, value: f64) -> f64 {
        self.from_px + (value - self.low) / (self.high - self.low) * (self.to_px - self.from_px)
    }

    /// Round values along the axis, about `pieces` + 1 of them, and the decimals they need.
    pub(crate) fn ticks(&self, pieces: f64) -> (Vec<f64>, usize) {
        let step = round_step(self.high - self.low, pieces);
        let first = (self.low / step - 1e-6).ceil() as i64;
        let last = (self.high / step + 1e-6).floor() as i64;
        let digits = (-step.log10().floor()).clamp(0.0, 6.0) as usize;
        ((first..=last).take(64).map(|k| k as f64 * step).collect(), digits)
    }
}

/// A round step that divides `span` into at most about `pieces` pieces.
fn round_step(span: f64, pieces: f64) -> f64 {
    let power = 10f64.powf((span / pieces).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|s| span / s <= pieces * 1.01).unwrap_or(10.0 * power)
}

/// Colours over 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colours {
    /// Dark to light, in the same order with colour blindness. Source: viridis of Smith & van der Walt 2015, eleven stops.
    Viridis,
    /// Blue over white to red. Source: `RdBu` of Brewer 2002, reversed, nine stops.
    Diverging,
    /// Light to dark blue. Source: Blues of Brewer 2002, nine stops.
    Blues,
}

impl Colours {
    #[allow(clippy::unreadable_literal)] // colours in the usual notation
    fn stops(self) -> &'static [u32] {
        match self {
            Self::Viridis => {
                &[0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e, 0x21918c, 0x22a884, 0x44bf70, 0x7ad151, 0xbddf26, 0xfde725]
            }
            Self::Diverging => &[0x2166ac, 0x4393c3, 0x92c5de, 0xd1e5f0, 0xf7f7f7, 0xfddbc7, 0xf4a582, 0xd6604d, 0xb2182b],
            Self::Blues => &[0xf7fbff, 0xdeebf7, 0xc6dbef, 0x9ecae1, 0x6baed6, 0x4292c6, 0x2171b5, 0x08519c, 0x08306b],
        }
    }

    /// The colour at a place from 0 to 1; beyond that, the colour of the end.
    pub(crate) fn at(self, place: f64) -> String {
        let stops = self.stops();
        let place = if place.is_finite() { place.clamp(0.0, 1.0) } else { 0.5 } * (stops.len() - 1) as f64;
        let k = (place.floor() as usize).min(stops.len() - 2);
        let fraction = place - k as f64;
        let mixed = [16, 8, 0].map(|shift| {
            let channel = |c: u32| f64::from((c >> shift) & 0xff);
            (channel(stops[k]) + fraction * (channel(stops[k + 1]) - channel(stops[k]))).round() as u8
        });
        format!("#{:02x}{:02x}{:02x}", mixed[0], mixed[1], mixed[2])
    }

    /// The stops, for the page's script.
    pub(crate) fn all(self) -> Vec<String> {
        self.stops().iter().map(|c| format!("#{c:06x}")).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_ends_on_round_numbers_and_ticks_are_within_it() {
        let scale = Scale::over([0.03, 0.97].into_iter(), true, 0.0, 100.0);
        assert_eq!((scale.low, scale.high), (0.0, 1.0));
        assert_eq!(scale.ticks(5.0).0.len(), 6);
        assert!((scale.at(0.5) - 50.0).abs() < 1e-9);
    }

    #[test]
    fn values_that_are_all_the_same_still_have_an_axis() {
        let scale = Scale::over([2.0; 3].into_iter(), false, 0.0, 10.0);
        assert!(scale.at(2.0).is_finite() && scale.ticks(5.0).0.len() < 64);
    }

    #[test]
    fn colours_begin_and_end_at_their_stops() {
        assert_eq!(Colours::Viridis.at(0.0), "#440154");
        assert_eq!(Colours::Viridis.at(2.0), "#fde725");
        assert_eq!(Colours::Diverging.at(0.5), "#f7f7f7");
    }
}
