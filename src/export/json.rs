//! `table2.json` as it is, with the JSON Schema that describes it. A map that is not verified has one field more, which says so.

use crate::export::MapSource;
use crate::export::file::File;

/// The published schema.
const SCHEMA: &str = include_str!("../../docs/schema/table2.schema.json");

pub(crate) fn files(source: &MapSource) -> Vec<File> {
    let text = if source.proof.is_verified {
        source.table2_json.clone()
    } else {
        let reason = serde_json::Value::String(source.proof.line());
        source.table2_json.replacen('{', &format!("{{\n  \"unverified\": {reason},"), 1)
    };
    vec![File::new("pivot_map.json", text), File::new("pivot_map.schema.json", SCHEMA.to_owned())]
}
