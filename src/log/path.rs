//! Message paths: `/topic.field.sub[0]`, slices `[a:b]` with both ends inclusive, −1 the last, filters `{field=="x"}`.
//!
//! The syntax is that of Foxglove and `PlotJuggler`, where `[:]{…}` is `{…}`, with one extension: on parallel arrays such as those of `sensor_msgs/JointState` a
//! filter picks the element whose sibling array matches: `/joint_states.velocity{name=="front_drive_joint"}`.

use super::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// A place in the messages of a topic.
#[derive(Debug, Clone, PartialEq)]
pub struct MessagePath {
    /// Name of the topic.
    pub topic: String,
    /// The way from the message to the value.
    pub steps: Vec<Step>,
    text: String,
}

/// One step into a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
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
    /// Way from the element to the field that is compared.
    pub field: Vec<String>,
    /// How it is compared.
    pub compare: Compare,
    /// With what.
    pub with: Literal,
}

/// How a filter compares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the names say it
pub enum Compare {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

/// What a filter compares with.
#[derive(Debug, Clone, PartialEq)]
pub enum Literal {
    /// A number; `true` is 1 and `false` 0.
    Number(f64),
    /// A text in quotes.
    Text(String),
}

impl MessagePath {
    /// Whether a slice picks several values of each message.
    pub fn is_list(&self) -> bool {
        self.steps.iter().any(|step| matches!(step, Step::Slice(first, last) if first.unwrap_or(0) != last.unwrap_or(-1)))
    }

    /// The path that takes `steps` from the messages of any topic.
    pub(super) fn inside(steps: Vec<Step>) -> Self {
        Self { topic: String::new(), steps, text: String::new() }
    }
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

    /// Whether a text passes; texts are only ever equal or not.
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

impl FromStr for MessagePath {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut parser = Parser { text, at: 0 };
        let topic = parser.topic()?;
        let mut steps = Vec::new();
        while parser.at < text.len() {
            let step = parser.step()?;
            // Foxglove writes `[:]{…}` for the elements that pass; a filter on the array says the same
            let everything = matches!(step, Step::Slice(None | Some(0), None | Some(-1)));
            if !(everything && parser.rest().starts_with('{')) {
                steps.push(step);
            }
        }
        Ok(Self { topic, steps, text: text.to_owned() })
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Parser<'a> {
    fn wrong<T>(&self, expected: &'static str) -> Result<T> {
        Err(Error::BadPath { path: self.text.to_owned(), column: self.text[..self.at].chars().count() + 1, expected })
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn eat(&mut self, token: &str) -> bool {
        let found = self.rest().starts_with(token);
        if found {
            self.at += token.len();
        }
        found
    }

    fn spaces(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    /// Everything up to one of `ends`.
    fn until(&mut self, ends: &[char]) -> &'a str {
        let rest = self.rest();
        let found = &rest[..rest.find(ends).unwrap_or(rest.len())];
        self.at += found.len();
        found
    }

    fn quoted(&mut self) -> Option<Result<String>> {
        let quote = self.rest().chars().next().filter(|c| matches!(c, '"' | '\''))?;
        self.at += 1;
        let mut value = String::new();
        let mut escaped = false;
        for (index, character) in self.rest().char_indices() {
            if escaped {
                value.push(character);
                escaped = false;
            } else if character == '\\' {
                escaped = true;
            } else if character == quote {
                self.at += index + 1;
                return Some(Ok(value));
            } else {
                value.push(character);
            }
        }
        Some(self.wrong("a closing quote"))
    }

    fn topic(&mut self) -> Result<String> {
        if let Some(topic) = self.quoted() {
            return topic;
        }
        match self.until(&['.', '[', '{']) {
            "" => self.wrong("a topic such as /drive/torque_command"),
            topic => Ok(topic.to_owned()),
        }
    }

    fn step(&mut self) -> Result<Step> {
        if self.eat(".") {
            return self.name().map(Step::Field);
        }
        if self.eat("[") {
            let first = self.integer()?;
            if self.eat(":") {
                let last = self.integer()?;
                return if self.eat("]") { Ok(Step::Slice(first, last)) } else { self.wrong("]") };
            }
            return match first {
                Some(index) if self.eat("]") => Ok(Step::Index(index)),
                Some(_) => self.wrong("] or :"),
                None => self.wrong("a whole number"),
            };
        }
        if self.eat("{") {
            let test = self.test()?;
            self.spaces();
            return if self.eat("}") { Ok(Step::Filter(test)) } else { self.wrong("}") };
        }
        self.wrong(". or [ or {")
    }

    fn name(&mut self) -> Result<String> {
        if let Some(name) = self.quoted() {
            return name;
        }
        match self.until(&['.', '[', '{', '}', '=', '!', '<', '>', ' ']) {
            "" => self.wrong("the name of a field"),
            name => Ok(name.to_owned()),
        }
    }

    fn integer(&mut self) -> Result<Option<i64>> {
        self.spaces();
        let digits = self.until(&[':', ']']).trim();
        if digits.is_empty() {
            return Ok(None);
        }
        digits.parse().map(Some).or_else(|_| self.wrong("a whole number before this place"))
    }

    fn test(&mut self) -> Result<Test> {
        self.spaces();
        let mut field = vec![self.name()?];
        while self.eat(".") {
            field.push(self.name()?);
        }
        self.spaces();
        let signs = [
            ("==", Compare::Equal),
            ("!=", Compare::NotEqual),
            ("<=", Compare::LessOrEqual),
            (">=", Compare::GreaterOrEqual),
            ("<", Compare::Less),
            (">", Compare::Greater),
        ];
        let Some((_, compare)) = signs.into_iter().find(|(sign, _)| self.eat(sign)) else {
            return self.wrong("== or another comparison");
        };
        self.spaces();
        let with = match self.quoted() {
            Some(text) => Literal::Text(text?),
            None => match self.until(&['}']).trim() {
                "true" => Literal::Number(1.0),
                "false" => Literal::Number(0.0),
                digits => match digits.parse::<f64>() {
                    Ok(number) => Literal::Number(number),
                    Err(_) => return self.wrong("a number, true, false, or a text in quotes before this place"),
                },
            },
        };
        Ok(Test { field, compare, with })
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
        assert_eq!(path.steps[2], Step::Index(2));
        assert_eq!(path.steps[4], Step::Index(-1));
        assert_eq!(path.steps[6], Step::Slice(Some(1), Some(3)));
        let Step::Filter(test) = &path.steps[8] else { panic!("{path:?}") };
        assert!(test.number(7.0) && !test.number(8.0));
    }

    #[test]
    fn a_filter_takes_text_numbers_and_truth() {
        let Step::Filter(test) = &parse(r#"/j.velocity{name=="front \"drive\""}"#).steps[1] else { panic!() };
        assert!(test.text(br#"front "drive""#));
        let Step::Filter(test) = &parse("/j.v{ a.b >= -1.5 }").steps[1] else { panic!() };
        assert_eq!(test.field, ["a", "b"]);
        assert!(test.number(-1.5) && !test.number(-1.6));
        let Step::Filter(test) = &parse("/j{on==true}.v").steps[0] else { panic!() };
        assert!(test.number(1.0));
    }

    #[test]
    fn a_topic_with_dots_is_quoted() {
        assert_eq!(parse(r#""/a.b".c"#).topic, "/a.b");
    }

    #[test]
    fn a_broken_path_names_the_column() {
        for (text, column) in [("/a.", 4), ("", 1), ("/a[x]", 5), ("/a{b=1}", 5), ("/a[1", 5), ("/a{b==\"x}", 8)] {
            let error = text.parse::<MessagePath>().unwrap_err();
            assert!(matches!(&error, Error::BadPath { column: c, .. } if *c == column), "{text}: {error}");
        }
    }
}
