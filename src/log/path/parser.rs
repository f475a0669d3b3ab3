//! Parses the text of a message path.

use crate::log::path::{Compare, Literal, MessagePath, PathStep, Test};
use crate::log::{Error, Result};
use crate::text::{name_from_outside, owned_name};
use std::str::FromStr;

/// Largest number of steps of one path.
const MAX_STEPS: usize = 64;

impl FromStr for MessagePath {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut parser = PathParser { text, at: 0 };
        let topic = parser.topic()?;
        let mut steps = Vec::new();
        while parser.at < text.len() {
            let step = parser.step()?;
            // Foxglove writes `[:]{…}` for the elements that pass; a filter on the array has the same meaning
            let everything = |step: &PathStep| matches!(step, PathStep::Slice(None | Some(0), None | Some(-1)));
            while matches!(step, PathStep::Filter(_)) && steps.last().is_some_and(everything) {
                steps.pop();
            }
            steps.push(step);
            if steps.len() > MAX_STEPS {
                return parser.wrong("the end: no message is that deep,");
            }
        }
        // the text as it was given, unless it would do more than be read
        let shown = name_from_outside(text);
        if shown == text {
            return Ok(Self { topic: owned_name(topic), steps, text: text.to_owned() });
        }
        Ok(Self::new(owned_name(topic), steps))
    }
}

/// The character of `{1b}` at the start of `text`, and its length in bytes.
fn code_point(text: &str) -> Option<(char, usize)> {
    let (digits, _) = text.strip_prefix('{')?.split_once('}')?;
    let character = char::from_u32(u32::from_str_radix(digits, 16).ok()?)?;
    Some((character, digits.len() + 2))
}

struct PathParser<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> PathParser<'a> {
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
        let mut skipped = 0; // bytes of a `{1b}` that were taken already
        for (index, character) in self.rest().char_indices() {
            if skipped > 0 {
                skipped -= character.len_utf8();
            } else if escaped {
                match character {
                    'u' => match code_point(&self.rest()[index + 1..]) {
                        Some((written, code)) => {
                            value.push(written);
                            skipped = code;
                        }
                        None => value.push('u'),
                    },
                    other => value.push(other),
                }
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
        let topic = match self.quoted() {
            Some(topic) => topic?,
            None => self.until(&['.', '[', '{']).to_owned(),
        };
        // no topic has an empty name, in quotes or not
        if topic.is_empty() {
            self.at = 0;
            return self.wrong("a topic such as /drive/torque_command");
        }
        Ok(topic)
    }

    fn step(&mut self) -> Result<PathStep> {
        // a slash may follow an index, as in series names of `PlotJuggler`
        if self.eat(".") || self.eat("/") {
            return self.name().map(PathStep::Field);
        }
        if self.eat("[") {
            let first = self.integer()?;
            if self.eat(":") {
                let last = self.integer()?;
                return if self.eat("]") { Ok(PathStep::Slice(first, last)) } else { self.wrong("]") };
            }
            return match first {
                Some(index) if self.eat("]") => Ok(PathStep::Index(index)),
                Some(_) => self.wrong("] or :"),
                None => self.wrong("a whole number"),
            };
        }
        if self.eat("{") {
            let test = self.test()?;
            self.spaces();
            return if self.eat("}") { Ok(PathStep::Filter(test)) } else { self.wrong("}") };
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
        let Some(compare) = Compare::ALL.into_iter().find(|compare| self.eat(compare.sign())) else {
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
