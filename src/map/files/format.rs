//! The `format` and `format_version` of the JSON artefacts.

use crate::map::{Error, Result};
use crate::text::owned_line;
use serde::de::DeserializeOwned;
use serde_json::Value;

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

/// The content of a file in JSON, whose `format` is `expected`. A field that is missing or wrong is named with its line and column.
///
/// # Errors
/// Not JSON, another format or version, a missing or wrong field.
pub(crate) fn parse_file<T: DeserializeOwned>(text: &str, expected: &'static str) -> Result<T> {
    let value = expect_format(text, expected)?;
    serde_json::from_value(value).map_err(|error| {
        // the same error, found in the text, knows its place
        serde_json::from_str::<T>(text).err().unwrap_or(error).into()
    })
}

/// Parses JSON and checks its `format` and `format_version`. Its texts are names and notes: they come out as [`owned_line`] shows them.
pub(crate) fn expect_format(text: &str, expected: &'static str) -> Result<Value> {
    let mut value: Value = serde_json::from_str(text)?;
    make_readable(&mut value);
    let found = value.get("format").and_then(Value::as_str).unwrap_or("missing");
    if found != expected {
        return Err(Error::WrongFormat { found: found.to_owned(), expected });
    }
    let version = value.get("format_version").and_then(Value::as_u64).unwrap_or(0);
    if version != u64::from(FORMAT_VERSION) {
        return Err(Error::UnknownVersion { found: version, known: FORMAT_VERSION });
    }
    Ok(value)
}

/// Every text of a document as it may be shown.
fn make_readable(value: &mut Value) {
    match value {
        Value::String(text) => *text = owned_line(std::mem::take(text)),
        Value::Array(items) => items.iter_mut().for_each(make_readable),
        Value::Object(fields) => fields.values_mut().for_each(make_readable),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_texts_of_a_foreign_file_are_on_one_line_and_move_no_cursor() {
        let text = r#"{"format": "a", "format_version": 1, "notes": ["fine\nverdict: pass", "\u001b[2J", "a \\ b"]}"#;
        let value = expect_format(text, "a").unwrap();
        assert_eq!(value["notes"], serde_json::json!(["fine\\nverdict: pass", "\\u{1b}[2J", "a \\ b"]));
    }
}
