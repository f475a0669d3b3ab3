//! Rules of a matrix with breaks.

use crate::check::{CheckSettings, Rule, RuleBreach, Severity};
use crate::import::foreign::{CellGrid, Misread, MisreadKind};

/// An axis of the matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GridAxis {
    /// From row to row.
    Rows,
    /// From column to column.
    Columns,
}

/// The meaning of a matrix.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Meaning {
    /// Name of the row axis.
    pub(crate) rows: &'static str,
    /// Name of the column axis.
    pub(crate) columns: &'static str,
    /// Along which axis values must change strictly.
    pub(crate) along: GridAxis,
    /// Whether they must rise; otherwise they must fall.
    pub(crate) rising: bool,
    /// Severity of a plateau.
    pub(crate) plateau: Severity,
}

/// A matrix to be judged.
pub(crate) struct JudgedGrid<'a> {
    pub(crate) grid: &'a CellGrid,
    pub(crate) meaning: Meaning,
    /// Prefix of every place: the gear of a map that has two.
    pub(crate) of: String,
    /// Cells that no torque reaches, whose value is therefore a limit.
    pub(crate) limited: Option<Vec<Vec<bool>>>,
}

/// The findings of the reader.
pub(crate) fn misread(misread: &[Misread]) -> impl Iterator<Item = RuleBreach> + '_ {
    misread.iter().map(|m| {
        let rule = match m.kind {
            MisreadKind::TooSmall => Rule::Size,
            MisreadKind::Ragged => Rule::RaggedRow,
            MisreadKind::NotANumber => Rule::NotANumber,
            MisreadKind::Malformed => Rule::Readable,
        };
        RuleBreach::whole(rule, Severity::Error, m.what.clone()).on(Some(m.line), m.column)
    })
}

impl JudgedGrid<'_> {
    /// The place of a cell.
    pub(crate) fn cell(&self, rule: Rule, severity: Severity, i: usize, j: usize, what: String) -> RuleBreach {
        let text = |breaks: &[Option<f64>], k: usize| breaks.get(k).copied().flatten().map_or("?".to_owned(), |b| b.to_string());
        let (row, column) = (text(&self.grid.row_breaks, i), text(&self.grid.column_breaks, j));
        let at = format!("{}{} {row}, {} {column}", self.of, self.meaning.rows, self.meaning.columns);
        RuleBreach::at(rule, severity, at, what).on(self.grid.lines.get(i).copied(), j + 2)
    }

    /// Places (i, j) of every line along `along`.
    fn lines(&self, along: GridAxis) -> Vec<Vec<(usize, usize)>> {
        let (rows, columns) = self.grid.shape();
        match along {
            GridAxis::Rows => (0..columns).map(|j| (0..rows).map(|i| (i, j)).collect()).collect(),
            GridAxis::Columns => (0..rows).map(|i| (0..columns).map(|j| (i, j)).collect()).collect(),
        }
    }

    fn breaks(&self, along: GridAxis) -> &[Option<f64>] {
        if along == GridAxis::Rows { &self.grid.row_breaks } else { &self.grid.column_breaks }
    }

    fn limited(&self, (i, j): (usize, usize)) -> bool {
        self.limited.as_ref().is_some_and(|l| l.get(i).and_then(|row| row.get(j)).copied().unwrap_or(false))
    }

    /// Breaks that do not increase, and steps far longer than the axis's others.
    pub(crate) fn axes(&self, findings: &mut Vec<RuleBreach>) {
        for (along, name) in [(GridAxis::Rows, self.meaning.rows), (GridAxis::Columns, self.meaning.columns)] {
            let breaks = self.breaks(along);
            let place = |k: usize| match along {
                GridAxis::Rows => (self.grid.lines.get(k).copied(), 1),
                // the header is the line before the first row, if lines are known
                GridAxis::Columns => (self.grid.lines.first().map(|_| 1), k + 2),
            };
            let steps = steps(breaks);
            for (k, pair) in breaks.windows(2).enumerate() {
                let [Some(before), Some(value)] = pair else { continue };
                let (line, column) = place(k + 1);
                if value <= before {
                    let what = format!("{name} {value} is not above the one before it ({before})");
                    let at = format!("{}break {} of {name}", self.of, k + 2);
                    findings.push(RuleBreach::at(Rule::AxisOrder, Severity::Error, at, what).on(line, column));
                }
            }
            for (from, to) in long_steps(breaks, &steps) {
                let at = format!("{}{name} {from} to {to}", self.of);
                let what = format!("a step more than {LONG_STEP} times the axis's usual one");
                findings.push(RuleBreach::at(Rule::RangeGap, Severity::Warning, at, what));
            }
        }
    }

    /// Neighbours along the command that fall where they should rise, or that do not change. `excused` cells may be level.
    pub(crate) fn monotone(&self, excused: impl Fn(usize, usize) -> bool, findings: &mut Vec<RuleBreach>) -> usize {
        let mut judged = 0;
        let (words, sign) = if self.meaning.rising { ("below", 1.0) } else { ("above", -1.0) };
        for line in self.lines(self.meaning.along) {
            for pair in line.windows(2) {
                let ((i0, j0), (i, j)) = (pair[0], pair[1]);
                let (Some(before), Some(value)) = (self.grid.at(i0, j0), self.grid.at(i, j)) else { continue };
                judged += 1;
                if sign * (value - before) < 0.0 {
                    let what = format!("{value} is {words} the value before it ({before})");
                    findings.push(self.cell(Rule::NotMonotone, Severity::Error, i, j, what));
                } else if value == before && !(self.limited(pair[0]) || self.limited(pair[1]) || (excused(i, j) && excused(i0, j0))) {
                    let what = format!("{value} is the value before it: no inverse there");
                    findings.push(self.cell(Rule::Plateau, self.meaning.plateau, i, j, what));
                }
            }
        }
        judged
    }

    /// Steps with a slope above `settings.slope_bound` times the slope that bounds nine in ten steps along the same axis.
    pub(crate) fn jumps(&self, settings: CheckSettings, findings: &mut Vec<RuleBreach>) {
        for along in [GridAxis::Rows, GridAxis::Columns] {
            let name = if along == GridAxis::Rows { self.meaning.rows } else { self.meaning.columns };
            let breaks = self.breaks(along);
            let mut steps = Vec::new();
            for pair in self.lines(along).iter().flat_map(|line| line.windows(2)) {
                let ((i0, j0), (i, j)) = (pair[0], pair[1]);
                let (k0, k) = if along == GridAxis::Rows { (i0, i) } else { (j0, j) };
                let (Some(from), Some(to)) = (breaks.get(k0).copied().flatten(), breaks.get(k).copied().flatten()) else { continue };
                let (Some(before), Some(value)) = (self.grid.at(i0, j0), self.grid.at(i, j)) else { continue };
                if to > from {
                    steps.push(((i, j), ((value - before) / (to - from)).abs(), before, value));
                }
            }
            let mut slopes: Vec<_> = steps.iter().map(|s| s.1).collect();
            slopes.sort_by(f64::total_cmp);
            let Some(&usual) = slopes.get(slopes.len() * 9 / 10) else { continue };
            for ((i, j), slope, before, value) in steps {
                if usual > 0.0 && slope > settings.slope_bound * usual {
                    let what = format!(
                        "from {before} to {value} along {name}: a slope of {slope:.3}, where nine in ten stay below {usual:.3} (bound: {} times that)",
                        settings.slope_bound
                    );
                    findings.push(self.cell(Rule::Jump, Severity::Warning, i, j, what));
                }
            }
        }
    }

    /// A speed axis that does not begin at 0.
    pub(crate) fn speed_from_zero(&self, along: GridAxis, severity: Severity, findings: &mut Vec<RuleBreach>) {
        if let Some(first) = self.breaks(along).first().copied().flatten().filter(|first| *first > 0.0) {
            let what = format!("speeds begin at {first}: a controller uses the value at the edge for lower speeds");
            findings.push(RuleBreach::at(Rule::RangeGap, severity, format!("{}speed 0 to {first}", self.of), what));
        }
    }
}

/// A step longer than this many usual steps is a gap. Placed breaks differ by a factor of five or six.
pub(crate) const LONG_STEP: f64 = 10.0;

fn steps(breaks: &[Option<f64>]) -> Vec<f64> {
    breaks.windows(2).filter_map(|pair| Some(pair[1]? - pair[0]?)).collect()
}

/// The steps of an axis that are longer than [`LONG_STEP`] times their median, from and to.
fn long_steps(breaks: &[Option<f64>], steps: &[f64]) -> Vec<(f64, f64)> {
    let mut sorted = steps.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(&median) = sorted.get(sorted.len() / 2).filter(|m| **m > 0.0) else { return Vec::new() };
    let pairs = breaks.windows(2).filter_map(|pair| Some((pair[0]?, pair[1]?)));
    pairs.filter(|(from, to)| to - from > LONG_STEP * median).collect()
}

/// The same for plain numbers.
pub(crate) fn long_steps_of(breaks: &[f64]) -> Vec<(f64, f64)> {
    let breaks: Vec<_> = breaks.iter().map(|b| Some(*b)).collect();
    long_steps(&breaks, &steps(&breaks))
}
