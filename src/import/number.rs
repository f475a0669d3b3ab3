//! A number of a text, with the worth of its last digit.

/// A number as it is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct WrittenNumber {
    /// Its value.
    pub(crate) value: f64,
    /// One in its last digit: 0.01 for `1.25`, 1 for `7`, 1e-5 for `1.2e-4`; 0 where more digits than a double has are written.
    pub(crate) last_digit: f64,
}

/// Digits that a double always keeps.
const KEPT_DIGITS: usize = 15;

impl WrittenNumber {
    /// Reads a number; `None` if it is none, or not finite.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let value: f64 = text.parse().ok()?;
        if !value.is_finite() {
            return None;
        }
        let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
        let exponent: i32 = exponent.parse().ok()?;
        let decimals = mantissa.split_once('.').map_or(0, |(_, after)| after.len());
        let digits = mantissa.trim_start_matches(['-', '+', '0', '.']).chars().filter(char::is_ascii_digit).count();
        let decimals = i32::try_from(decimals).unwrap_or(i32::MAX);
        let last_digit = if digits > KEPT_DIGITS { 0.0 } else { 10f64.powi(exponent.saturating_sub(decimals)) };
        Some(Self { value, last_digit })
    }

    /// The same in other units.
    pub(crate) fn scaled(self, scale: f64, offset: f64) -> Self {
        Self { value: scale * self.value + offset, last_digit: scale.abs() * self.last_digit }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_is_that_of_the_text() {
        let digit = |text: &str| WrittenNumber::parse(text).map(|w| w.last_digit);
        assert_eq!((digit("1.25"), digit("7"), digit("-0.000001")), (Some(0.01), Some(1.0), Some(1e-6)));
        assert!(digit("1.2e-4").is_some_and(|d| (d - 1e-5).abs() < 1e-18));
        assert_eq!((digit("0.12345678901234567"), digit("x"), digit("inf")), (Some(0.0), None, None));
    }
}
