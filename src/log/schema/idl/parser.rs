//! The text of a definition into what it defines.

use crate::log::schema::idl::definition::{Definitions, IdlDefinition, IdlName, Member};
use crate::log::schema::shape::{Kind, MAX_DEPTH, Shape};
use std::collections::BTreeMap;

/// Reads a definition.
///
/// # Errors
/// What cannot be understood.
pub(crate) fn read(text: &str) -> Result<Definitions, String> {
    let tokens = tokens(text)?;
    let mut parser =
        IdlParser { tokens: &tokens, at: 0, scope: Vec::new(), found: Definitions { types: BTreeMap::new(), constants: BTreeMap::new() } };
    parser.specification()?;
    Ok(parser.found)
}

/// Words, numbers, strings (empty) and single signs; `::` belongs to the word.
fn tokens(text: &str) -> Result<Vec<&str>, String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    loop {
        rest = rest.trim_start();
        let Some(first) = rest.chars().next() else { return Ok(tokens) };
        let length = if rest.starts_with("//") || first == '#' || rest.starts_with("===") || rest.starts_with("IDL:") {
            rest = &rest[rest.find('\n').unwrap_or(rest.len())..];
            continue;
        } else if rest.starts_with("/*") {
            let end = rest.find("*/").ok_or("a comment has no end")?;
            rest = &rest[end + 2..];
            continue;
        } else if first == '"' || first == '\'' {
            let mut escaped = false;
            let inside = |c: char| {
                let end = c == first && !escaped;
                escaped = c == '\\' && !escaped;
                end
            };
            let end = rest[1..].find(inside).ok_or("a text has no closing quote")?;
            tokens.push("\"\"");
            rest = &rest[end + 2..];
            continue;
        } else if first.is_alphanumeric() || first == '_' || rest.starts_with("::") {
            let is_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | ':' | '.');
            rest.find(|c| !is_word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        tokens.push(&rest[..length]);
        rest = &rest[length..];
    }
}

struct IdlParser<'a> {
    tokens: &'a [&'a str],
    at: usize,
    scope: Vec<&'a str>,
    found: Definitions,
}

impl<'a> IdlParser<'a> {
    fn peek(&self) -> &'a str {
        self.tokens.get(self.at).copied().unwrap_or_default()
    }

    fn next(&mut self) -> Result<&'a str, String> {
        let token = self.tokens.get(self.at).copied().ok_or("the definition ends too early")?;
        self.at += 1;
        Ok(token)
    }

    fn expect(&mut self, sign: &str) -> Result<(), String> {
        match self.next()? {
            found if found == sign => Ok(()),
            found => Err(format!("{sign:?} is expected before {found:?}")),
        }
    }

    fn full(&self, name: &str) -> String {
        self.scope.iter().copied().chain([name]).collect::<Vec<_>>().join("::")
    }

    fn specification(&mut self) -> Result<(), String> {
        while self.at < self.tokens.len() {
            match self.next()? {
                "@" => self.annotation()?,
                "module" => {
                    let name = self.next()?;
                    self.expect("{")?;
                    self.scope.push(name);
                }
                "}" => {
                    self.scope.pop().ok_or("a brace closes nothing")?;
                }
                ";" => {}
                "struct" => self.structure()?,
                "typedef" => {
                    let kind = self.named()?;
                    let (name, lengths) = self.declarator()?;
                    let full = self.full(name);
                    self.found.types.insert(full, IdlDefinition::Alias(kind, lengths));
                    self.expect(";")?;
                }
                "enum" => {
                    let name = self.full(self.peek());
                    self.next()?;
                    while self.next()? != "}" {}
                    self.found.types.insert(name, IdlDefinition::Enumeration);
                }
                "const" => self.constant()?,
                other => return Err(format!("{other:?} is not understood")),
            }
        }
        Ok(())
    }

    /// Passes over `@name` and its arguments in brackets.
    fn annotation(&mut self) -> Result<(), String> {
        self.next()?;
        if self.peek() == "(" {
            let mut open = 0_usize;
            loop {
                match self.next()? {
                    "(" => open += 1,
                    ")" => open -= 1,
                    _ => {}
                }
                if open == 0 {
                    break;
                }
            }
        }
        Ok(())
    }

    fn structure(&mut self) -> Result<(), String> {
        let name = self.next()?;
        self.expect("{")?;
        let mut members = Vec::new();
        loop {
            match self.peek() {
                "}" => break,
                "@" => {
                    self.at += 1;
                    self.annotation()?;
                }
                _ => {
                    let kind = self.named()?;
                    loop {
                        let (name, lengths) = self.declarator()?;
                        members.push(Member { name: name.to_owned(), kind: kind.clone(), lengths });
                        match self.next()? {
                            ";" => break,
                            "," => {}
                            other => return Err(format!("\";\" is expected before {other:?}")),
                        }
                    }
                }
            }
        }
        self.expect("}")?;
        let full = self.full(name);
        self.found.types.insert(full, IdlDefinition::Structure(members));
        Ok(())
    }

    fn declarator(&mut self) -> Result<(&'a str, Vec<usize>), String> {
        let name = self.next()?;
        let mut lengths = Vec::new();
        while self.peek() == "[" {
            self.at += 1;
            let length = self.next()?;
            lengths.push(length.parse().map_err(|_| format!("the array length {length:?} is no number"))?);
            self.expect("]")?;
        }
        Ok((name, lengths))
    }

    fn constant(&mut self) -> Result<(), String> {
        self.named()?;
        let name = self.next()?;
        self.expect("=")?;
        let mut value = String::new();
        while self.peek() != ";" {
            value.push_str(self.next()?);
        }
        self.expect(";")?;
        if let Ok(number) = value.parse() {
            self.found.constants.entry(self.scope.join("::")).or_default().push((name.to_owned(), number));
        }
        Ok(())
    }

    /// A type; sequences of sequences are unwrapped in a loop.
    fn named(&mut self) -> Result<IdlName, String> {
        let mut sequences = 0;
        while self.peek() == "sequence" {
            self.at += 1;
            self.expect("<")?;
            sequences += 1;
            if sequences > MAX_DEPTH {
                return Err(format!("sequences are nested more than {MAX_DEPTH} deep"));
            }
        }
        let number = |kind| IdlName::Scalar(Shape::Number(kind));
        let mut kind = match self.next()? {
            "boolean" => number(Kind::Bool),
            "octet" | "uint8" | "char" => number(Kind::U8),
            "int8" => number(Kind::I8),
            "short" | "int16" => number(Kind::I16),
            "uint16" | "wchar" => number(Kind::U16),
            "int32" => number(Kind::I32),
            "uint32" => number(Kind::U32),
            "int64" => number(Kind::I64),
            "uint64" => number(Kind::U64),
            "float" => number(Kind::F32),
            "double" => number(Kind::F64),
            "long" => match self.peek() {
                "long" => {
                    self.at += 1;
                    number(Kind::I64)
                }
                "double" => return Err("long double is not understood".into()),
                _ => number(Kind::I32),
            },
            "unsigned" => match self.next()? {
                "short" => number(Kind::U16),
                "long" if self.peek() == "long" => {
                    self.at += 1;
                    number(Kind::U64)
                }
                "long" => number(Kind::U32),
                other => return Err(format!("unsigned {other} is not understood")),
            },
            word @ ("string" | "wstring") => {
                if self.peek() == "<" {
                    self.at += 1;
                    self.next()?;
                    self.expect(">")?;
                }
                IdlName::Scalar(if word == "string" { Shape::Text } else { Shape::WideText })
            }
            word @ ("union" | "map" | "bitset" | "bitmask" | "fixed" | "any") => return Err(format!("{word} is not understood")),
            name => IdlName::Type { name: name.to_owned(), scope: self.scope.join("::") },
        };
        for _ in 0..sequences {
            if self.peek() == "," {
                self.at += 1;
                self.next()?;
            }
            self.expect(">")?;
            kind = IdlName::Sequence(Box::new(kind));
        }
        Ok(kind)
    }
}
