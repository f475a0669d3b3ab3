//! The heat map of one gear: the change of every cell over its standard error, with its values on hover.

use crate::diff::{MapDiff, Table};
use maud::{Markup, html};

/// |z| at which the colour is full.
const FULL_Z: f64 = 6.0;
/// Size of the picture, and place and size of its cells [px].
const VIEW: (f64, f64) = (960.0, 500.0);
const LEFT: f64 = 64.0;
const TOP: f64 = 8.0;
const WIDTH: f64 = 880.0;
const HEIGHT: f64 = 420.0;

/// The picture with its caption.
pub(crate) fn heat_map(table: Table, map: &MapDiff) -> Markup {
    let label = format!("change over standard error, {} gear", map.gear);
    html! {
        figure {
            svg viewBox={ "0 0 " (VIEW.0) " " (VIEW.1) } role="img" aria-label=(label) {
                @for i in 0..map.rows.len() {
                    @for j in 0..map.columns.len() { (cell(table, map, i, j)) }
                }
                (axes(table, map))
            }
            figcaption {
                "Change over its standard error: blue where b is lower, red where b is higher, full colour from ±" (FULL_Z) "; outlined where \
                 significant; grey where not compared. Values on hover."
            }
        }
    }
}

/// Left and top of a cell. The first row is at the bottom, as on a graph.
fn corner(map: &MapDiff, i: usize, j: usize) -> (f64, f64) {
    let (w, h) = size(map);
    (LEFT + w * j as f64, TOP + h * (map.rows.len() - 1 - i) as f64)
}

/// Width and height of a cell.
fn size(map: &MapDiff) -> (f64, f64) {
    (WIDTH / map.columns.len() as f64, HEIGHT / map.rows.len() as f64)
}

fn cell(table: Table, map: &MapDiff, i: usize, j: usize) -> Markup {
    let ([rows_name, columns_name], unit) = (table.axes(), table.unit());
    let (row, column) = (map.rows[i], map.columns[j]);
    let ((x, y), (w, h)) = (corner(map, i, j), size(map));
    let (fill, value) = match map.change[i][j].zip(map.std_err[i][j]).zip(map.z[i][j]) {
        Some(((change, error), z)) => (colour(z), format!("{change:+.4} ± {error:.4} {unit}, z {z:+.1}")),
        None => ("var(--none)".to_owned(), "not compared".to_owned()),
    };
    let significant = map.largest.iter().any(|c| c.row == row && c.column == column);
    html! {
        rect x=(px(x)) y=(px(y)) width=(px(w - 0.5)) height=(px(h - 0.5)) fill=(fill)
            stroke=[significant.then_some("var(--fg)")] stroke-width=[significant.then_some("1")] {
            title { (rows_name) " " (row) ", " (columns_name) " " (column) ": " (value) }
        }
    }
}

/// Numbers along the axes, and the axes' names.
fn axes(table: Table, map: &MapDiff) -> Markup {
    let [rows_name, columns_name] = table.axes();
    let (w, h) = size(map);
    let (middle_x, middle_y) = (LEFT + 0.5 * WIDTH, TOP + 0.5 * HEIGHT);
    html! {
        @for i in ticks(map.rows.len()) {
            text x=(LEFT - 6.0) y=(px(corner(map, i, 0).1 + 0.5 * h + 4.0)) text-anchor="end" { (map.rows[i]) }
        }
        @for j in ticks(map.columns.len()) {
            text x=(px(LEFT + w * (j as f64 + 0.5))) y=(TOP + HEIGHT + 18.0) text-anchor="middle" { (map.columns[j]) }
        }
        text x=(middle_x) y=(TOP + HEIGHT + 40.0) text-anchor="middle" { (columns_name) }
        text x="14" y=(middle_y) text-anchor="middle" transform={ "rotate(-90 14 " (middle_y) ")" } { (rows_name) }
    }
}

/// A coordinate to a tenth of a pixel.
fn px(value: f64) -> String {
    format!("{value:.1}")
}

/// About ten of `count` places, the first among them.
fn ticks(count: usize) -> impl Iterator<Item = usize> {
    (0..count).step_by(count.div_ceil(10).max(1))
}

/// Blue below 0, red above, over the page's neutral colour.
fn colour(z: f64) -> String {
    let share = (100.0 * (z.abs() / FULL_Z).min(1.0)).round();
    let end = if z < 0.0 { "#2166ac" } else { "#b2182b" };
    format!("color-mix(in oklab,{end} {share}%,var(--zero))")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diff::Significant;
    use crate::map::Gear;

    /// Two rows and three columns; the middle cell of the upper row changed, the last one was not compared.
    fn map() -> MapDiff {
        let known = |value: f64| vec![vec![Some(0.0); 3], vec![Some(0.0), Some(value), None]];
        let changed =
            Significant { row: 1.0, column: 0.5, a: 1.0, b: 0.7, change: -0.3, std_err: 0.1, z: -3.0, p: 0.0027, accel_mps2: -0.3 };
        MapDiff {
            gear: Gear::Forward,
            wheel_angle_deg: 90.0,
            interpolated: false,
            compared: 5,
            left_out: 1,
            significant: 1,
            matters: 1,
            rms_change: 0.1,
            rms_z: 1.0,
            largest: vec![changed],
            rows: vec![-1.0, 1.0],
            columns: vec![0.0, 0.5, 1.0],
            change: known(-0.3),
            std_err: known(0.1),
            z: known(-3.0),
        }
    }

    #[test]
    fn a_changed_cell_is_coloured_outlined_and_explained() {
        let changed = cell(Table::Table1, &map(), 1, 1).into_string();
        assert!(changed.contains("fill=\"color-mix(in oklab,#2166ac 50%,var(--zero))\" stroke=\"var(--fg)\""), "{changed}");
        assert!(changed.contains("torque [N·m] 1, speed [m/s] 0.5: -0.3000 ± 0.1000 m/s², z -3.0"), "{changed}");
        // the upper row begins at the top, its second column a third of the width to the right
        assert!(changed.contains("x=\"357.3\" y=\"8.0\" width=\"292.8\" height=\"209.5\""), "{changed}");
    }

    #[test]
    fn a_cell_that_was_not_compared_says_so_without_an_outline() {
        let empty = cell(Table::Table1, &map(), 1, 2).into_string();
        assert!(empty.contains("fill=\"var(--none)\"") && empty.contains(": not compared<") && !empty.contains("stroke"), "{empty}");
    }

    #[test]
    fn colours_are_full_from_their_bound_on() {
        assert_eq!(colour(-60.0), "color-mix(in oklab,#2166ac 100%,var(--zero))");
        assert_eq!(colour(0.0), "color-mix(in oklab,#b2182b 0%,var(--zero))");
    }

    #[test]
    fn a_long_axis_has_about_ten_numbers() {
        assert_eq!(ticks(4).collect::<Vec<_>>(), [0, 1, 2, 3]);
        for count in [10, 11, 57, 2000] {
            let found: Vec<usize> = ticks(count).collect();
            assert!(found[0] == 0 && (5..=10).contains(&found.len()) && found.iter().all(|k| *k < count), "{count}: {found:?}");
        }
        assert_eq!(ticks(0).count(), 0);
    }
}
