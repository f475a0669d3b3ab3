//! The `format` and `format_version` of the JSON artefacts.

use crate::map::{Error, Result};

/// Version of the JSON artefacts that this library writes, and the only one that it reads.
pub(crate) const FORMAT_VERSION: u32 = 1;

/// The `format` field of a `table1.json`.
pub(crate) const TABLE1_FORMAT: &str = "pivot-cal/table1";

/// The `format` field of a `table2.json`.
pub(crate) const TABLE2_FORMAT: &str = "pivot-cal/table2";

/// The `format` field of a `lateral_table.json`.
pub(crate) const LATERAL_TABLE_FORMAT: &str = "pivot-cal/lateral-table";

/// The `format` field of a `fit_traces.json`.
pub(crate) const FIT_TRACES_FORMAT: &str = "pivot-cal/fit_traces";

/// Parses JSON and checks its `format` and `format_version`.
pub(crate) fn expect_format(text: &str, expected: &'static str) -> Result<serde_json::Value> {
    let value: serde_json::Value = serde_json::from_str(text)?;
    let found = value.get("format").and_then(serde_json::Value::as_str).unwrap_or("missing");
    if found != expected {
        return Err(Error::WrongFormat { found: found.to_owned(), expected });
    }
    let version = value.get("format_version").and_then(serde_json::Value::as_u64).unwrap_or(0);
    if version != u64::from(FORMAT_VERSION) {
        return Err(Error::UnknownVersion { found: version, known: FORMAT_VERSION });
    }
    Ok(value)
}
