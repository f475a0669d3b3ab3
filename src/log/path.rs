//! Message paths: `/topic.field.sub[0]`, slices `[a:b]` with both ends inclusive, −1 the last, filters `{field=="x"}`.
//!
//! The syntax is that of Foxglove and `PlotJuggler`, where `[:]{…}` is `{…}`, with one extension: on parallel arrays such as those of
//! `sensor_msgs/JointState`, a filter selects the element whose sibling array matches:
//! `/joint_states.velocity{name=="front_drive_joint"}`.

mod parser;

use crate::text::escaped_in_quotes;
use std::fmt::{self, Write as _};

/// A place in the messages of a topic.
#[derive(Debug, Clone, PartialEq)]
pub struct MessagePath {
    /// Name of the topic.
    pub topic: String,
    /// The steps from the message to the value.
    pub steps: Vec<PathStep>,
    text: String,
}

/// One step into a message.
#[derive(Debug, Clone, PartialEq)]
pub enum PathStep {
    /// Into the field of this name.
    Field(String),
    /// To an element of an array; negative counts from the end.
    Index(i64),
    /// To the elements from the first to the second, both included; negative counts from the end.
    Slice(Option<i64>, Option<i64>),
    /// To the first element (of an array) that passes, or no further if the message does not pass.
    Filter(Test),
}

/// A filter's condition.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// Path from the element to the compared field.
    pub field: Vec<String>,
    /// The comparison.
    pub compare: Compare,
    /// The value to compare with.
    pub with: Literal,
}

/// The comparison of a filter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the names are self-explanatory
pub enum Compare {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// The value that a filter compares with.
#[derive(Debug, Clone, PartialEq)]
pub enum Literal {
    /// A number; `true` is 1 and `false` 0.
    Number(f64),
    /// A string in quotes.
    Text(String),
}

impl MessagePath {
    /// Whether a slice selects several values of each message.
    pub fn is_list(&self) -> bool {
        self.steps.iter().any(|step| matches!(step, PathStep::Slice(first, last) if first.unwrap_or(0) != last.unwrap_or(-1)))
    }

    /// The path that takes `steps` from the messages of any topic.
    pub(crate) fn inside(steps: Vec<PathStep>) -> Self {
        Self { topic: String::new(), steps, text: String::new() }
    }

    /// A column of a table by its name, of which no part means a step.
    pub(crate) fn column(name: &str) -> Self {
        Self { topic: name.to_owned(), steps: Vec::new(), text: name.to_owned() }
    }

    /// The path that takes `steps` from the messages of `topic`.
    pub(crate) fn new(topic: String, steps: Vec<PathStep>) -> Self {
        let mut text = if topic.contains(['.', '[', '{', '"', '\\', '\'']) { quoted(&topic) } else { topic.clone() };
        for step in &steps {
            let _ = write!(text, "{step}");
        }
        Self { topic, steps, text }
    }
}

/// A string in quotes, as written in paths.
pub(crate) fn quoted(text: &str) -> String {
    let text = text.replace('\\', "\\\\").replace('"', "\\\"");
    format!("\"{}\"", escaped_in_quotes(&text))
}

/// A field's name, in quotes where it needs them.
fn name(name: &str) -> String {
    let plain = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '/' | ':' | '$'));
    if plain { name.to_owned() } else { quoted(name) }
}

impl Test {
    /// Whether a number passes.
    pub fn number(&self, value: f64) -> bool {
        let Literal::Number(with) = self.with else {
            return false;
        };
        match self.compare {
            Compare::Equal => value == with,
            Compare::NotEqual => value != with,
            Compare::Less => value < with,
            Compare::LessOrEqual => value <= with,
            Compare::Greater => value > with,
            Compare::GreaterOrEqual => value >= with,
        }
    }

    /// Whether a string passes; strings are only compared for equality.
    pub fn text(&self, value: &[u8]) -> bool {
        let Literal::Text(with) = &self.with else {
            return false;
        };
        match self.compare {
            Compare::Equal => value == with.as_bytes(),
            Compare::NotEqual => value != with.as_bytes(),
            _ => false,
        }
    }
}

impl fmt::Display for MessagePath {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl fmt::Display for PathStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let end = |end: &Option<i64>| end.map(|end| end.to_string()).unwrap_or_default();
        match self {
            Self::Field(field) => write!(f, ".{}", name(field)),
            Self::Index(index) => write!(f, "[{index}]"),
            Self::Slice(first, last) => write!(f, "[{}:{}]", end(first), end(last)),
            Self::Filter(test) => write!(f, "{{{test}}}"),
        }
    }
}

impl fmt::Display for Test {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let field: Vec<String> = self.field.iter().map(|field| name(field)).collect();
        write!(f, "{}{}", field.join("."), self.compare.sign())?;
        match &self.with {
            Literal::Number(number) => write!(f, "{number}"),
            Literal::Text(text) => f.write_str(&quoted(text)),
        }
    }
}

impl Compare {
    /// Every comparison; longer signs come before their prefixes.
    const ALL: [Self; 6] = [Self::Equal, Self::NotEqual, Self::LessOrEqual, Self::GreaterOrEqual, Self::Less, Self::Greater];

    fn sign(self) -> &'static str {
        match self {
            Self::Equal => "==",
            Self::NotEqual => "!=",
            Self::LessOrEqual => "<=",
            Self::GreaterOrEqual => ">=",
            Self::Less => "<",
            Self::Greater => ">",
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn parse(text: &str) -> MessagePath {
        text.parse().unwrap()
    }

    #[test]
    fn fields_indexes_slices_and_filters_are_steps() {
        let path = parse("/a/b.c.d[2].e[-1].f[1:3].g{id==7}.h");
        assert_eq!(path.topic, "/a/b");
        assert_eq!(path.steps.len(), 10);
        assert_eq!(path.steps[2], PathStep::Index(2));
        assert_eq!(path.steps[4], PathStep::Index(-1));
        assert_eq!(path.steps[6], PathStep::Slice(Some(1), Some(3)));
        let PathStep::Filter(test) = &path.steps[8] else { panic!("{path:?}") };
        assert!(test.number(7.0) && !test.number(8.0));
    }

    #[test]
    fn a_filter_takes_text_numbers_and_truth() {
        let PathStep::Filter(test) = &parse(r#"/j.velocity{name=="front \"drive\""}"#).steps[1] else { panic!() };
        assert!(test.text(br#"front "drive""#));
        let PathStep::Filter(test) = &parse("/j.v{ a.b >= -1.5 }").steps[1] else { panic!() };
        assert_eq!(test.field, ["a", "b"]);
        assert!(test.number(-1.5) && !test.number(-1.6));
        let PathStep::Filter(test) = &parse("/j{on==true}.v").steps[0] else { panic!() };
        assert!(test.number(1.0));
    }

    #[test]
    fn a_path_made_of_steps_is_read_back_unchanged() {
        for text in [r#"/a/b.c."d e"[2].e[-1].f[1:].g{id>=7.5}.h"#, r#""/a.b".velocity{n.name=="q \" \\ ü"}"#, "/a[:3]"] {
            let path = parse(text);
            let made = MessagePath::new(path.topic.clone(), path.steps.clone());
            assert_eq!((made.to_string(), parse(&made.to_string()).steps), (text.to_owned(), path.steps));
        }
    }

    #[test]
    fn a_field_with_an_escape_in_its_name_is_written_out_and_read_back() {
        let path = MessagePath::new("/a".to_owned(), vec![PathStep::Field("x\u{1b}[2J\n\u{202e}".to_owned())]);
        assert_eq!(path.to_string(), r#"/a."x\u{1b}[2J\u{a}\u{202e}""#);
        assert_eq!(parse(&path.to_string()).steps, path.steps);
        assert_eq!(parse("/a.\"x\u{1b}\"").to_string(), r#"/a."x\u{1b}""#);
    }

    #[test]
    fn slices_of_everything_before_a_filter_are_the_filter_alone() {
        assert_eq!(parse("/a.b[:][0:][:-1]{c==1}.d").steps, parse("/a.b{c==1}.d").steps);
    }

    #[test]
    fn a_path_without_end_is_refused() {
        assert!(matches!(("/a".to_owned() + &".b".repeat(100_000)).parse::<MessagePath>(), Err(crate::log::Error::BadPath { .. })));
    }

    #[test]
    fn a_topic_with_dots_is_quoted() {
        assert_eq!(parse(r#""/a.b".c"#).topic, "/a.b");
    }

    #[test]
    fn a_broken_path_names_the_column() {
        for (text, column) in [("/a.", 4), ("", 1), (r#""".a"#, 1), ("/a[x]", 5), ("/a{b=1}", 5), ("/a[1", 5), ("/a{b==\"x}", 8)] {
            let error = text.parse::<MessagePath>().unwrap_err();
            assert!(matches!(&error, crate::log::Error::BadPath { column: c, .. } if *c == column), "{text}: {error}");
        }
    }
}
