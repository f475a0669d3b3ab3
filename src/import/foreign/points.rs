//! A map as a list of points, as Apollo and long-form CSV files hold it.

/// One point of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CommandPoint {
    /// Line of the text, counted from 1.
    pub line: u64,
    /// Speed [m/s].
    pub speed: f64,
    /// Acceleration [m/s²].
    pub accel: f64,
    /// Command: torque, or per cent of throttle (positive) and brake (negative).
    pub command: f64,
}

/// All points in the order of the file, and the name of the command.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct CommandPoints {
    /// The points.
    pub points: Vec<CommandPoint>,
    /// Name of the command.
    pub command: String,
}

impl CommandPoints {
    /// The points by speed, ascending, each row by acceleration, ascending; the file's order decides between equal ones.
    pub(crate) fn rows(&self) -> Vec<(f64, Vec<CommandPoint>)> {
        let mut points = self.points.clone();
        points.sort_by(|a, b| a.speed.total_cmp(&b.speed).then(a.accel.total_cmp(&b.accel)));
        let mut rows: Vec<(f64, Vec<CommandPoint>)> = Vec::new();
        for point in points {
            match rows.last_mut() {
                Some((speed, row)) if *speed == point.speed => row.push(point),
                _ => rows.push((point.speed, vec![point])),
            }
        }
        rows
    }
}
