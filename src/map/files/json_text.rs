//! JSON as people read it: objects indented, arrays of plain values on one line.

use crate::map::Result;
use serde::Serialize;
use serde_json::Value;

/// The text of `value`, with a final line end. Keys keep the order of the struct's fields.
pub(crate) fn to_text(value: &impl Serialize) -> Result<String> {
    let value = serde_json::to_value(value)?;
    let mut text = String::new();
    write(&value, 0, &mut text)?;
    text.push('\n');
    Ok(text)
}

fn write(value: &Value, depth: usize, text: &mut String) -> Result<()> {
    let indent = |text: &mut String, depth: usize| {
        text.push('\n');
        (0..depth).for_each(|_| text.push_str("  "));
    };
    match value {
        Value::Object(fields) if !fields.is_empty() => {
            text.push('{');
            for (k, (name, field)) in fields.iter().enumerate() {
                if k > 0 {
                    text.push(',');
                }
                indent(text, depth + 1);
                text.push_str(&serde_json::to_string(name)?);
                text.push_str(": ");
                write(field, depth + 1, text)?;
            }
            indent(text, depth);
            text.push('}');
        }
        Value::Array(items) if items.iter().any(|i| i.is_array() || i.is_object()) => {
            text.push('[');
            for (k, item) in items.iter().enumerate() {
                if k > 0 {
                    text.push(',');
                }
                indent(text, depth + 1);
                write(item, depth + 1, text)?;
            }
            indent(text, depth);
            text.push(']');
        }
        plain => text.push_str(&serde_json::to_string(plain)?),
    }
    Ok(())
}
