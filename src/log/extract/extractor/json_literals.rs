//! Literals that JSON does not have but that many writers use: NaN, Infinity.
//!
//! Python writes them for numbers that are not finite. One of them in a field that is not wanted must not lose the message.

/// The literals, as Python, JavaScript and C print them; the longest first where one begins with another.
const LITERALS: [&[u8]; 7] = [b"-Infinity", b"Infinity", b"NaN", b"-inf", b"nan", b"inf", b"-nan"];

/// The payload with every such literal in quotes; `None` if it has none. A text such as `"NaN"` is read as a number where a number is wanted.
pub(crate) fn quoted_literals(payload: &[u8]) -> Option<Vec<u8>> {
    let mut quoted = Vec::new();
    let (mut copied, mut at) = (0, 0);
    let mut in_text = false;
    while at < payload.len() {
        match payload[at] {
            b'\\' if in_text => at += 1,
            b'"' => in_text = !in_text,
            _ if in_text => {}
            _ => {
                let is_word = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
                let ends = |literal: &&&[u8]| !payload.get(at + literal.len()).is_some_and(is_word);
                let found = LITERALS.iter().filter(|literal| payload[at..].starts_with(literal)).find(ends);
                if let Some(literal) = found.filter(|_| at == 0 || !is_word(&payload[at - 1])) {
                    quoted.extend_from_slice(&payload[copied..at]);
                    quoted.push(b'"');
                    quoted.extend_from_slice(literal);
                    quoted.push(b'"');
                    at += literal.len();
                    copied = at;
                    continue;
                }
            }
        }
        at += 1;
    }
    if copied == 0 {
        return None;
    }
    quoted.extend_from_slice(&payload[copied..]);
    Some(quoted)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn literals_outside_texts_are_quoted_and_texts_are_left() {
        let quoted = |text: &str| quoted_literals(text.as_bytes()).map(|bytes| String::from_utf8(bytes).unwrap());
        assert_eq!(
            quoted(r#"{"a":NaN,"NaN":[1,-Infinity,inf],"b":"NaN \"nan"}"#).unwrap(),
            r#"{"a":"NaN","NaN":[1,"-Infinity","inf"],"b":"NaN \"nan"}"#
        );
        assert_eq!(quoted(r#"{"info":1,"b":"Infinity"}"#), None);
        assert_eq!(quoted("NaNo"), None);
        assert_eq!(quoted(r#"{"a":"unfinished \"#), None);
    }
}
