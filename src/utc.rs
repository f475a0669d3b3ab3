//! Times of day as RFC 3339 writes them: the start of a campaign is read, the start of a log is shown.
//!
//! Source of the calendar: Hinnant, *chrono-Compatible Low-Level Date Algorithms* (2013), `days_from_civil` and `civil_from_days`.

/// Nanoseconds in one second.
const NS: u64 = 1_000_000_000;

/// Days from 1970-01-01 to a day of the Gregorian calendar.
fn days(year: i64, month: i64, day: i64) -> i64 {
    // years begin in March, so that the leap day is a year's last
    let year = if month <= 2 { year - 1 } else { year };
    let (era, year_of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

/// Year, month and day, `days` after 1970-01-01.
fn civil(days: i64) -> (i64, i64, i64) {
    let days = days + 719_468;
    let (era, day_of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    (era * 400 + year_of_era + i64::from(month <= 2), month, day)
}

/// A time after 1970 to the whole second: `2026-01-15T08:00:00Z`.
pub(crate) fn text(ns_since_1970: u64) -> String {
    let seconds = (ns_since_1970 / NS) as i64;
    let (year, month, day) = civil(seconds / 86_400);
    let of_day = seconds % 86_400;
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", of_day / 3600, of_day / 60 % 60, of_day % 60)
}

/// Nanoseconds since 1970 of a time such as `2026-01-15T08:00:00Z` or `2026-01-15T09:00:00.25+01:00`.
///
/// # Errors
/// What is wrong with the text.
pub(crate) fn parse(text: &str) -> Result<u64, String> {
    let shape = || "expected YYYY-MM-DDThh:mm:ssZ, or with a fraction of a second and an offset such as +01:00 for Z".to_owned();
    let text = text.trim();
    if text.len() < 20 || !text.is_ascii() {
        return Err(shape());
    }
    let (time, zone) = text.split_at(19);
    let is_as = |k: usize, of: &[u8]| of.contains(&time.as_bytes()[k]);
    let separated = is_as(4, b"-") && is_as(7, b"-") && is_as(10, b"Tt ") && is_as(13, b":") && is_as(16, b":");
    let number = |text: &str| if text.bytes().all(|b| b.is_ascii_digit()) { text.parse::<i64>().ok() } else { None };
    let fields = [0..4, 5..7, 8..10, 11..13, 14..16, 17..19].map(|range| number(&time[range]));
    let [Some(year), Some(month), Some(day), Some(hour), Some(minute), Some(second)] = fields else { return Err(shape()) };
    if !separated {
        return Err(shape());
    }
    // a leap second counts as the second before it, as clocks of computers have it
    let (second, is_leap) = (second.min(59), second == 60);
    let is_day = (1..=12).contains(&month) && day >= 1 && civil(days(year, month, day)) == (year, month, day);
    if !is_day || hour > 23 || minute > 59 || (!is_leap && number(&time[17..19]) > Some(59)) {
        return Err("there is no such date or time of day".to_owned());
    }
    let (fraction, zone) = match zone.strip_prefix('.') {
        Some(rest) => {
            let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
            let (fraction, zone) = rest.split_at(digits);
            if !(1..=9).contains(&digits) {
                return Err("a fraction of a second has one to nine digits".to_owned());
            }
            (number(&format!("{fraction:0<9}")).ok_or_else(shape)?, zone)
        }
        None => (0, zone),
    };
    let offset_s = match zone.as_bytes() {
        [b'Z' | b'z'] => 0,
        [sign @ (b'+' | b'-'), _, _, b':', _, _] => {
            let (Some(hours @ 0..=23), Some(minutes @ 0..=59)) = (number(&zone[1..3]), number(&zone[4..6])) else { return Err(shape()) };
            (hours * 3600 + minutes * 60) * if *sign == b'+' { 1 } else { -1 }
        }
        _ => return Err(shape()),
    };
    let seconds = days(year, month, day) * 86_400 + hour * 3600 + minute * 60 + second - offset_s;
    let ns = u64::try_from(seconds).ok().and_then(|seconds| seconds.checked_mul(NS)).and_then(|ns| ns.checked_add(fraction as u64));
    ns.ok_or_else(|| "it must lie between 1970 and 2554".to_owned())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn times_are_those_of_a_calendar() {
        for (seconds, time) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_700_000_000, "2023-11-14T22:13:20Z"),
            (1_768_464_000, "2026-01-15T08:00:00Z"),
            (4_107_542_399, "2100-02-28T23:59:59Z"),
            (4_107_542_400, "2100-03-01T00:00:00Z"),
        ] {
            assert_eq!(text(seconds * NS + 999_999_999), time);
            assert_eq!(parse(time).unwrap(), seconds * NS);
        }
    }

    #[test]
    fn every_day_is_the_day_after_the_one_before() {
        for day in 0..220_000 {
            let (year, month, of_month) = civil(day);
            assert_eq!(days(year, month, of_month), day);
            let next = civil(day + 1);
            assert!(next == (year, month, of_month + 1) || next == (year, month + 1, 1) || next == (year + 1, 1, 1));
        }
    }

    #[test]
    fn offsets_and_fractions_count() {
        let utc = parse("2026-01-15T08:00:00Z").unwrap();
        assert_eq!(parse("2026-01-15T09:30:00+01:30").unwrap(), utc);
        assert_eq!(parse("2026-01-14 20:00:00.25-12:00").unwrap(), utc + 250_000_000);
        assert_eq!(parse("2026-01-15t08:00:00.000000001z").unwrap(), utc + 1);
        assert_eq!(parse("2016-12-31T23:59:60Z").unwrap(), parse("2016-12-31T23:59:59Z").unwrap());
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in [
            "noon",
            "2026-01-15",
            "2026-01-15T08:00:00",
            "2026-01-15T08:00:00ZZ",
            "2026-01-15T08:00:00+1:00",
            "2026-01-15T08:00:00.Z",
            "2026-01-15T08:00:00.0000000001Z",
            "2026-02-29T08:00:00Z",
            "2026-13-01T08:00:00Z",
            "2026-00-01T08:00:00Z",
            "2026-01-00T08:00:00Z",
            "2026-01-15T24:00:00Z",
            "2026-01-15T08:60:00Z",
            "2026-01-15T08:00:61Z",
            "2026-01-15T08:00:+1Z",
            "1969-12-31T23:59:59Z",
            "1970-01-01T00:00:00+00:01",
            "9999-01-01T00:00:00Z",
            "2026-01-15T08:00:00é",
        ] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
