//! The times of a table: counts of a unit, exact to the nanosecond however many digits there are, or dates.

use crate::log::columns::cell::{TableCell, with_point};
use jiff::civil::DateTime;
use jiff::tz::TimeZone;

/// How the cells of the time column are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TimeForm {
    /// Numbers, each this many nanoseconds.
    Count { ns_per_unit: i64 },
    /// ISO 8601; without a zone, in UTC.
    Date,
    /// Times whose type gives their unit.
    Typed,
}

impl TimeForm {
    /// The name of the unit in a note.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Count { ns_per_unit: 1 } => "ns",
            Self::Count { ns_per_unit: 1_000 } => "us",
            Self::Count { ns_per_unit: 1_000_000 } => "ms",
            Self::Count { .. } => "s",
            Self::Date => "ISO 8601",
            Self::Typed => "given by the column's type",
        }
    }

    /// The form of a column whose header names no unit, from one of its cells. A date shows what it is. A number that would be a date of our
    /// time in ns, us or ms since 1970 is one; any other counts seconds.
    pub(crate) fn of(cell: &TableCell<'_>) -> Option<Self> {
        match cell {
            TableCell::Instant(_) => return Some(Self::Typed),
            TableCell::Text(text) if date_ns(text).is_some() => return Some(Self::Date),
            _ => {}
        }
        let ns_per_unit = match cell.number()?.abs() {
            size if size >= 1e17 => 1,
            size if size >= 1e14 => 1_000,
            size if size >= 1e11 => 1_000_000,
            size if size.is_finite() => 1_000_000_000,
            _ => return None,
        };
        Some(Self::Count { ns_per_unit })
    }

    /// The time of a cell [ns]; `None` if it holds none.
    pub(crate) fn time_ns(self, cell: &TableCell<'_>) -> Option<i64> {
        match (self, cell) {
            (_, TableCell::Instant(time_ns)) => Some(*time_ns),
            (Self::Count { ns_per_unit }, TableCell::Integer(count)) => count.checked_mul(ns_per_unit),
            (Self::Count { ns_per_unit }, TableCell::Number(count)) => rounded(count * ns_per_unit as f64),
            (Self::Count { ns_per_unit }, TableCell::Text(text)) => count_ns(text, ns_per_unit),
            (Self::Date, TableCell::Text(text)) => date_ns(text),
            _ => None,
        }
    }
}

fn rounded(time_ns: f64) -> Option<i64> {
    (time_ns.abs() < i64::MAX as f64).then(|| time_ns.round() as i64)
}

/// Digits of a count that are kept: the others are less than a nanosecond, or the count is no time.
const MOST_DIGITS: usize = 30;

/// `1700000000.123456789` with its last digit, which no `f64` holds.
fn count_ns(text: &str, ns_per_unit: i64) -> Option<i64> {
    let text = text.trim();
    let text = with_point(text).unwrap_or_else(|| text.to_owned());
    let (sign, digits) = text.strip_prefix('-').map_or((1, text.strip_prefix('+').unwrap_or(&text)), |rest| (-1, rest));
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let is_plain = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit()) && part.len() <= MOST_DIGITS;
    if whole.is_empty() && fraction.is_empty() || !is_plain(whole) || !is_plain(fraction) {
        // an exponent, or more digits than a time has
        let value: f64 = text.parse().ok()?;
        return rounded(value * ns_per_unit as f64);
    }
    let number = |part: &str| if part.is_empty() { Some(0) } else { part.parse::<i128>().ok() };
    let scale = i128::from(ns_per_unit);
    let power = 10_i128.pow(fraction.len().min(18) as u32);
    let fraction = number(&fraction[..fraction.len().min(18)])?;
    let time_ns = number(whole)?.checked_mul(scale)?.checked_add((fraction * scale + power / 2) / power)?;
    i64::try_from(sign * time_ns).ok()
}

/// A date of ISO 8601, with `T` or a space, with or without a zone [ns since 1970].
fn date_ns(text: &str) -> Option<i64> {
    let text = text.trim();
    // every date begins with a year; numbers are not tried
    if text.len() < 10 || text.as_bytes().get(4) != Some(&b'-') {
        return None;
    }
    let time = match text.parse::<jiff::Timestamp>() {
        Ok(time) => time,
        Err(_) => text.parse::<DateTime>().ok()?.to_zoned(TimeZone::UTC).ok()?.timestamp(),
    };
    i64::try_from(time.as_nanosecond()).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(text: &str) -> TableCell<'_> {
        TableCell::Text(text.into())
    }

    #[test]
    fn counts_are_exact_to_the_nanosecond() {
        let seconds = TimeForm::Count { ns_per_unit: 1_000_000_000 };
        let expected = [
            ("1700000000.123456789", Some(1_700_000_000_123_456_789)),
            ("-0,5", Some(-500_000_000)),
            (".25", Some(250_000_000)),
            ("1.7e9", Some(1_700_000_000_000_000_000)),
            ("0.1234567894", Some(123_456_789)),
            ("99999999999", None),
            ("1.2.3", None),
            ("x", None),
        ];
        for (written, time_ns) in expected {
            assert_eq!(seconds.time_ns(&text(written)), time_ns, "{written}");
        }
        assert_eq!(TimeForm::Count { ns_per_unit: 1_000_000 }.time_ns(&text("20.000001")), Some(20_000_001));
    }

    #[test]
    fn dates_with_and_without_a_zone_are_times_of_utc() {
        for written in ["2024-05-01T10:00:00.5Z", "2024-05-01 10:00:00.500", "2024-05-01 12:00:00.5+02:00"] {
            assert_eq!(TimeForm::of(&text(written)), Some(TimeForm::Date), "{written}");
            assert_eq!(TimeForm::Date.time_ns(&text(written)), Some(1_714_557_600_500_000_000), "{written}");
        }
        assert_eq!(TimeForm::of(&text("10:00:00")), None);
    }

    #[test]
    fn the_size_of_a_number_tells_the_unit_of_a_date() {
        let name = |written: &str| TimeForm::of(&text(written)).map(TimeForm::name);
        let expected =
            [("12.5", "s"), ("1700000000.5", "s"), ("1700000000500", "ms"), ("1700000000500000", "us"), ("1700000000500000000", "ns")];
        for (written, unit) in expected {
            assert_eq!(name(written), Some(unit));
        }
    }
}
