//! `table2.json` as it is, with the JSON Schema that describes it.

use crate::export::MapSource;
use crate::export::file::File;

/// The published schema.
const SCHEMA: &str = include_str!("../../docs/schema/table2.schema.json");

pub(crate) fn files(source: &MapSource) -> Vec<File> {
    vec![File::new("pivot_map.json", source.table2_json.clone()), File::new("pivot_map.schema.json", SCHEMA.to_owned())]
}
