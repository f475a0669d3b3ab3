//! Names of the maps' CSV files.

use crate::map::{Gear, WheelAngle};

/// Name of a map's CSV: `table1.csv` at the test angle, `table1.angle30.csv` elsewhere, with `.reverse` before `.csv` for reverse gear.
pub(crate) fn csv_name(table: &str, gear: Gear, wheel_angle_deg: f64, test_angle_deg: f64) -> String {
    let angle = if WheelAngle::from_deg(test_angle_deg).is_same_deg(wheel_angle_deg) {
        String::new()
    } else {
        format!(".angle{}", crate::map::decimal(wheel_angle_deg))
    };
    format!("{table}{angle}{}.csv", gear.file_infix())
}

/// Whether `name` is a result of [`csv_name`] for `table`.
pub(crate) fn is_csv_name(name: &str, table: &str) -> bool {
    let Some(middle) = name.strip_prefix(table).and_then(|rest| rest.strip_suffix(".csv")) else { return false };
    let middle = middle.strip_suffix(Gear::Reverse.file_infix()).unwrap_or(middle);
    middle.is_empty() || middle.strip_prefix(".angle").is_some_and(|angle| angle.parse::<f64>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_angle_has_the_plain_names_and_other_angles_are_in_the_name() {
        let name = |gear, angle| csv_name("table1", gear, angle, 90.0);
        assert_eq!(name(Gear::Forward, 90.0), "table1.csv");
        assert_eq!(name(Gear::Reverse, 90.0), "table1.reverse.csv");
        assert_eq!(name(Gear::Forward, 30.0), "table1.angle30.csv");
        assert_eq!(name(Gear::Reverse, -22.5), "table1.angle-22.5.reverse.csv");
        for name in ["table1.csv", "table1.reverse.csv", "table1.angle30.csv", "table1.angle-22.5.reverse.csv"] {
            assert!(is_csv_name(name, "table1") && !is_csv_name(name, "table2"), "{name}");
        }
        for name in ["table1.json", "table1.old.csv", "table1.anglex.csv", "my_table1.csv"] {
            assert!(!is_csv_name(name, "table1"), "{name}");
        }
    }
}
