//! Changes between two maps, where they are, and whether they are more than chance; and the cells that a person changed in a file.
//!
//! In: two `table1.json` or two `table2.json`. Out: a [`MapComparison`] with a verdict, and a heat map as HTML.
//!
//! Per cell z = (b − a) / √(σ_a² + σ_b²), and from it a two-sided p. With hundreds of cells some z are large by chance. The
//! Benjamini-Hochberg procedure keeps the expected share of false ones among those called significant below the rate asked for. If nothing
//! changed it is Simes' test, and finds anything at all with a probability of at most that rate.
//!
//! Source: Y. Benjamini, Y. Hochberg, Controlling the false discovery rate, J. R. Stat. Soc. B 57 (1995) 289–300; that it holds for
//! positively dependent cells, as neighbours on a smooth surface are: Y. Benjamini, D. Yekutieli, Ann. Statist. 29 (2001) 1165–1188.

mod compare;
mod comparison;
mod edited;
mod error;
mod heat_map;
mod html;
mod sheet;
mod significance;

pub(crate) use compare::compare;
pub(crate) use comparison::{DiffSettings, DiffVerdict, MapComparison, MapDiff, Significant};
pub(crate) use edited::{EditedMap, edited};
pub(crate) use error::{Error, Result};
pub(crate) use html::html;
pub(crate) use sheet::{DiffSide, Table};
