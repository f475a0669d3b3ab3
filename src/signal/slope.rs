//! A line through the start.

/// Slope of the least-squares line y = s·x through (0, 0); 0 without points away from it.
pub(crate) fn slope_through_origin(points: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let (along, squares) = points.into_iter().fold((0.0, 0.0), |(along, squares), (x, y)| (along + x * y, squares + x * x));
    along / f64::max(squares, 1e-12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_points_count_more() {
        assert!((slope_through_origin([(1.0, 2.0), (3.0, 6.0)]) - 2.0).abs() < 1e-12);
        assert!((slope_through_origin([(1.0, 0.0), (3.0, 6.0)]) - 1.8).abs() < 1e-12);
        assert!(slope_through_origin([]).abs() < 1e-12);
    }
}
