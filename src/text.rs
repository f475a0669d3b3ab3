//! Text from outside, made fit to be shown: names of topics, schemas and files, notes of foreign map files.
//!
//! In: text that somebody else wrote. Out: text that moves no cursor, breaks no line, turns no reading direction and has a bounded length.
//! Every name passes [`name_from_outside`] or [`shown`] where it enters. What leaves passes [`for_terminal`] or [`for_json`] as well.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

/// Longest name that is kept whole [characters]. ROS allows 255 for a topic.
const LONGEST_NAME: usize = 256;
/// Characters kept of a longer one.
const KEPT: usize = 200;
/// Digits in a row from which a number is written with an exponent: no `f64` below 1e22 has more.
const MOST_DIGITS: usize = 22;

/// A name from outside as it is shown, stored and matched. Control characters, escapes, line breaks, and marks that turn the reading direction
/// or have no width, become `\u{…}`; a backslash beside them is doubled, so that different names stay different. Of a name with more than
/// 256 characters the first 200 are kept, with its length and checksum.
pub(crate) fn name_from_outside(name: &str) -> Cow<'_, str> {
    let is_long = name.char_indices().nth(LONGEST_NAME).is_some();
    let short = if is_long {
        let end = name.char_indices().nth(KEPT).map_or(name.len(), |(at, _)| at);
        Cow::Owned(format!("{}… ({} bytes, crc {:08x})", &name[..end], name.len(), crc32fast::hash(name.as_bytes())))
    } else {
        Cow::Borrowed(name)
    };
    match escaped(&short) {
        Some(escaped) => Cow::Owned(escaped),
        None => short,
    }
}

/// A note from outside, of any length, on one line; otherwise as [`name_from_outside`].
pub(crate) fn owned_line(line: String) -> String {
    escaped(&line).unwrap_or(line)
}

/// The text with everything written out that is not for reading; `None` if there is nothing of that kind.
fn escaped(text: &str) -> Option<String> {
    if !text.contains(is_active) {
        return None;
    }
    let mut escaped = String::with_capacity(text.len() + 8);
    for character in text.chars() {
        match character {
            '\\' => escaped.push_str("\\\\"),
            '\n' => escaped.push_str("\\n"),
            '\r' => escaped.push_str("\\r"),
            '\t' => escaped.push_str("\\t"),
            active if is_active(active) => _ = write!(escaped, "\\u{{{:x}}}", u32::from(active)),
            plain => escaped.push(plain),
        }
    }
    Some(escaped)
}

/// The same characters as code points, `\u{1b}`, for text that is put in quotes and read back.
pub(crate) fn escaped_in_quotes(text: &str) -> String {
    text.chars().fold(String::with_capacity(text.len()), |mut escaped, character| {
        if is_active(character) {
            let _ = write!(escaped, "\\u{{{:x}}}", u32::from(character));
        } else {
            escaped.push(character);
        }
        escaped
    })
}

/// [`name_from_outside`] of an owned name, which is kept where nothing is to be changed.
pub(crate) fn owned_name(name: String) -> String {
    match name_from_outside(&name) {
        Cow::Borrowed(_) => name,
        Cow::Owned(changed) => changed,
    }
}

/// A path as it is shown: on one line, whatever its bytes are.
pub(crate) fn shown(path: impl AsRef<Path>) -> String {
    name_from_outside(&path.as_ref().to_string_lossy()).into_owned()
}

/// Text for a terminal or a pipe: line ends stay, everything else that is not for reading is escaped, and a number with more than 22 digits is
/// written with an exponent.
pub(crate) fn for_terminal(text: &str) -> Cow<'_, str> {
    let is_safe = !text.chars().any(|c| is_active(c) && c != '\n');
    let text = if is_safe {
        Cow::Borrowed(text)
    } else {
        Cow::Owned(text.chars().fold(String::new(), |mut safe, character| {
            match character {
                '\n' => safe.push('\n'),
                '\t' => safe.push(' '),
                active if is_active(active) => _ = write!(safe, "\\u{{{:x}}}", u32::from(active)),
                plain => safe.push(plain),
            }
            safe
        }))
    };
    match shortened(&text) {
        Some(short) => Cow::Owned(short),
        None => text,
    }
}

/// JSON text in which such characters are written as JSON's own escapes: the same document, safe to print.
pub(crate) fn for_json(json: String) -> String {
    if !json.chars().any(|c| is_active(c) && c != '\n') {
        return json;
    }
    let mut units = [0; 2];
    json.chars().fold(String::with_capacity(json.len()), |mut safe, character| {
        if character == '\n' || !is_active(character) {
            safe.push(character);
        } else {
            for unit in character.encode_utf16(&mut units) {
                let _ = write!(safe, "\\u{unit:04x}");
            }
        }
        safe
    })
}

/// Whether a character does something other than being read.
fn is_active(character: char) -> bool {
    character.is_control() // C0, DEL, C1
        || matches!(
            character,
            '\u{061c}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}'
                | '\u{e0000}'..='\u{e007f}'
        )
}

/// The text with its overlong numbers written with an exponent; `None` if it has none.
fn shortened(text: &str) -> Option<String> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let mut digits = 0;
    let has_many = |c: char| {
        digits = if c.is_ascii_digit() { digits + 1 } else { 0 };
        digits > MOST_DIGITS
    };
    if !text.chars().any(has_many) {
        return None;
    }
    let (mut short, mut rest) = (String::new(), text);
    while let Some(start) = rest.find(is_part) {
        let (before, from) = rest.split_at(start);
        let end = from.find(|c| !is_part(c)).unwrap_or(from.len());
        let (number, after) = from.split_at(end);
        short.push_str(before);
        // within a word, as a hash is, it is no number
        let is_word = before.ends_with(char::is_alphanumeric) || after.starts_with(char::is_alphanumeric);
        match number.trim_end_matches('.').parse::<f64>() {
            Ok(value) if number.len() > MOST_DIGITS && !is_word => {
                let _ = write!(short, "{value:e}");
                short.extend(number.chars().rev().take_while(|c| *c == '.'));
            }
            _ => short.push_str(number),
        }
        rest = after;
    }
    short.push_str(rest);
    Some(short)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_is_not_for_reading_is_written_out() {
        assert_eq!(name_from_outside("/drive/torque_command"), "/drive/torque_command");
        assert_eq!(name_from_outside("größe 速度 …"), "größe 速度 …");
        assert_eq!(name_from_outside("a\u{1b}[2Jb"), "a\\u{1b}[2Jb");
        assert_eq!(name_from_outside("a\u{9b}2J\u{7f}"), "a\\u{9b}2J\\u{7f}");
        assert_eq!(name_from_outside("a\nverdict: pass\r"), "a\\nverdict: pass\\r");
        assert_eq!(name_from_outside("a\u{202e}b\u{2066}c\u{200b}"), "a\\u{202e}b\\u{2066}c\\u{200b}");
    }

    #[test]
    fn different_names_stay_different() {
        assert_ne!(name_from_outside("\u{1b}\\u{1b}"), name_from_outside("\\u{1b}\u{1b}"));
        let (a, b) = ("x".repeat(1000) + "a", "x".repeat(1000) + "b");
        assert_ne!(name_from_outside(&a), name_from_outside(&b));
    }

    #[test]
    fn a_name_of_16_mb_is_short() {
        let name = name_from_outside(&"\u{1b}x".repeat(8 << 20)).into_owned();
        assert!(name.len() < 2000 && name.contains("(16777216 bytes, crc "), "{}", name.len());
    }

    #[test]
    fn a_table_keeps_its_lines_on_the_terminal() {
        assert_eq!(for_terminal("a  b\n1  2\n"), "a  b\n1  2\n");
        assert_eq!(for_terminal("a\u{1b}[31m\nb"), "a\\u{1b}[31m\nb");
    }

    #[test]
    fn json_stays_the_same_document() {
        let value = serde_json::json!({ "a\u{9b}": "\u{202e}\u{e0001}\n é" });
        let text = for_json(value.to_string());
        assert!(!text.contains(is_active), "{text}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&text).ok(), Some(value));
    }

    #[test]
    fn a_huge_number_has_an_exponent_and_a_hash_does_not() {
        assert_eq!(for_terminal(&format!("wheelbase_m is {}; allowed: …", 1e300)), "wheelbase_m is 1e300; allowed: …");
        assert_eq!(for_terminal(&format!("-{}.", 2.5e-300)), "-2.5e-300.");
        let hash = "1".repeat(40) + "ab" + &"2".repeat(22);
        assert_eq!(for_terminal(&hash), hash);
        assert_eq!(for_terminal("1234567890.123456789012 is kept"), "1234567890.123456789012 is kept");
    }

    proptest! {
        #[test]
        fn no_text_leaves_anything_active(text in any::<String>()) {
            prop_assert!(!name_from_outside(&text).contains(is_active));
            prop_assert!(!for_terminal(&text).contains(|c| is_active(c) && c != '\n'));
            let name = name_from_outside(&text);
            prop_assert_eq!(for_terminal(&name).into_owned().contains(is_active), false);
        }
    }
}
