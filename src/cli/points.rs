//! Points of a polyline from a file: x and y in metres per line, east and north of any origin, and optionally the set speed [m/s] of the
//! segment that begins there.

use crate::cli::text_file::read_file;
use crate::guidance::route::polyline::PolylinePoint;
use crate::text::shown;
use anyhow::{Context, bail};
use std::path::Path;

/// Largest number of points of a file.
const MOST: usize = 1000;

/// Reads the points. A first line without numbers is a heading; empty lines are skipped.
pub(crate) fn read(path: &Path) -> anyhow::Result<Vec<PolylinePoint>> {
    let text = read_file(path)?;
    points(&text).with_context(|| shown(path))
}

fn points(text: &str) -> anyhow::Result<Vec<PolylinePoint>> {
    let mut points = Vec::new();
    for (k, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let cells: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
        let numbers: Vec<f64> = cells.iter().filter_map(|cell| cell.parse().ok()).collect();
        match numbers[..] {
            [x_m, y_m] if cells.len() == 2 || (cells.len() == 3 && cells[2].is_empty()) => points.push([x_m, y_m].into()),
            [x_m, y_m, speed_mps] if cells.len() == 3 => points.push(PolylinePoint { x_m, y_m, speed_mps: Some(speed_mps) }),
            [] if k == 0 => {}
            _ => bail!(
                "line {}: {line:?} is not a point; a line holds x and y in metres, as 6.0,4.0, and optionally the set speed in m/s of the \
                 segment that begins there, as 6.0,4.0,0.5",
                k + 1
            ),
        }
        if points.len() > MOST {
            bail!("more than {MOST} points; this is the most for a polyline");
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn points_are_read_with_or_without_a_heading_and_a_bad_line_is_named() {
        let at = |x_m, y_m, speed_mps| PolylinePoint { x_m, y_m, speed_mps };
        assert_eq!(points("x_m,y_m\n0,0\n\n6.5; -4\n").unwrap(), [at(0.0, 0.0, None), at(6.5, -4.0, None)]);
        assert_eq!(points("1\t2").unwrap(), [at(1.0, 2.0, None)]);
        let with_speeds = points("x_m,y_m,speed_mps\n0,0,0.5\n4,0,\n4,4,0.3").unwrap();
        assert_eq!(with_speeds, [at(0.0, 0.0, Some(0.5)), at(4.0, 0.0, None), at(4.0, 4.0, Some(0.3))]);
        assert!(points("").unwrap().is_empty());
        for (text, place) in
            [("0,0\n1", "line 2"), ("0,0\n1,x", "line 2"), ("0,0,fast", "line 1"), ("0,0,0,0", "line 1"), ("x,y\nx,y", "line 2")]
        {
            assert!(points(text).unwrap_err().to_string().contains(place), "{text}");
        }
        assert!(points(&"0,1\n".repeat(MOST + 1)).is_err());
    }
}
