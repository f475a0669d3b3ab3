//! ROS 2 interface definitions in OMG IDL (ros2idl schemas): modules, structures, typedefs, enumerations, constants.
//!
//! Only what ROS 2 generates is understood; unions, maps and bit sets are an error. Parsed without recursion into the text, so that no
//! schema exhausts the stack. Source: OMG IDL 4.2, and <https://design.ros2.org/articles/idl_interface_definition.html>.

use super::shape::{Kind, MAX_DEPTH, Shape, Size, Structure};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Parses a definition into the shape of the message `name` (`pkg/msg/Name`).
///
/// # Errors
/// What cannot be parsed, or the type that is missing.
pub(super) fn parse(name: &str, text: &str) -> Result<Arc<Structure>, String> {
    let tokens = tokens(text)?;
    let mut parser = Parser { tokens: &tokens, at: 0, scope: Vec::new(), definitions: BTreeMap::new(), constants: BTreeMap::new() };
    parser.specification()?;
    let Parser { definitions, constants, .. } = parser;
    let mut builder = Builder { definitions, constants, built: BTreeMap::new() };
    builder.structure(&name.replace('/', "::"), 0)
}

/// A name or type as written.
#[derive(Debug, Clone)]
enum Named {
    Scalar(Shape),
    /// A defined type, and the scope in which it is named.
    Type {
        name: String,
        scope: String,
    },
    Sequence(Box<Named>),
}

#[derive(Debug, Clone)]
enum Definition {
    Structure(Vec<Member>),
    Alias(Named, Vec<usize>),
    Enumeration,
}

#[derive(Debug, Clone)]
struct Member {
    name: String,
    kind: Named,
    /// Lengths of a fixed array, the outermost first.
    lengths: Vec<usize>,
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

struct Parser<'a> {
    tokens: &'a [&'a str],
    at: usize,
    scope: Vec<&'a str>,
    definitions: BTreeMap<String, Definition>,
    /// Constants by the module that holds them.
    constants: BTreeMap<String, Vec<(String, i64)>>,
}

impl<'a> Parser<'a> {
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
                    self.definitions.insert(full, Definition::Alias(kind, lengths));
                    self.expect(";")?;
                }
                "enum" => {
                    let name = self.full(self.peek());
                    self.next()?;
                    while self.next()? != "}" {}
                    self.definitions.insert(name, Definition::Enumeration);
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
        self.definitions.insert(full, Definition::Structure(members));
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
            self.constants.entry(self.scope.join("::")).or_default().push((name.to_owned(), number));
        }
        Ok(())
    }

    /// A type; sequences of sequences are unwrapped in a loop.
    fn named(&mut self) -> Result<Named, String> {
        let mut sequences = 0;
        while self.peek() == "sequence" {
            self.at += 1;
            self.expect("<")?;
            sequences += 1;
            if sequences > MAX_DEPTH {
                return Err(format!("sequences are nested more than {MAX_DEPTH} deep"));
            }
        }
        let number = |kind| Named::Scalar(Shape::Number(kind));
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
                Named::Scalar(if word == "string" { Shape::Text } else { Shape::WideText })
            }
            word @ ("union" | "map" | "bitset" | "bitmask" | "fixed" | "any") => return Err(format!("{word} is not understood")),
            name => Named::Type { name: name.to_owned(), scope: self.scope.join("::") },
        };
        for _ in 0..sequences {
            if self.peek() == "," {
                self.at += 1;
                self.next()?;
            }
            self.expect(">")?;
            kind = Named::Sequence(Box::new(kind));
        }
        Ok(kind)
    }
}

struct Builder {
    definitions: BTreeMap<String, Definition>,
    constants: BTreeMap<String, Vec<(String, i64)>>,
    built: BTreeMap<String, Arc<Structure>>,
}

impl Builder {
    fn structure(&mut self, full: &str, depth: usize) -> Result<Arc<Structure>, String> {
        if let Some(built) = self.built.get(full) {
            return Ok(built.clone());
        }
        if depth > MAX_DEPTH {
            return Err(format!("messages are nested more than {MAX_DEPTH} deep, or contain themselves"));
        }
        let Some(Definition::Structure(members)) = self.definitions.get(full).cloned() else {
            return Err(format!("it does not hold the type {}", full.replace("::", "/")));
        };
        let mut fields = Vec::with_capacity(members.len());
        for member in members {
            let shape = self.shape(&member.kind, depth)?;
            fields.push((member.name, arrays(shape, &member.lengths)));
        }
        let constants = Arc::new(self.constants.get(&format!("{full}_Constants")).cloned().unwrap_or_default());
        let built = Arc::new(Structure { name: full.replace("::", "/"), fields, constants });
        self.built.insert(full.to_owned(), built.clone());
        Ok(built)
    }

    fn shape(&mut self, kind: &Named, depth: usize) -> Result<Shape, String> {
        if depth > 2 * MAX_DEPTH {
            return Err("types refer to each other without end".into());
        }
        match kind {
            Named::Scalar(shape) => Ok(shape.clone()),
            Named::Sequence(of) => Ok(Shape::List(Box::new(self.shape(of, depth + 1)?), Size::Counted)),
            Named::Type { name, scope } => {
                let full = self.find(name, scope).ok_or_else(|| format!("it does not hold the type {name}"))?;
                match self.definitions.get(&full).cloned() {
                    Some(Definition::Alias(kind, lengths)) => Ok(arrays(self.shape(&kind, depth + 1)?, &lengths)),
                    Some(Definition::Enumeration) => Ok(Shape::Number(Kind::U32)),
                    _ => Ok(Shape::Message(self.structure(&full, depth + 1)?)),
                }
            }
        }
    }

    /// The full name of a type: looked for in the scope where it is named, then further out.
    fn find(&self, name: &str, scope: &str) -> Option<String> {
        let name = name.trim_start_matches("::");
        let mut scope = scope;
        loop {
            let full = if scope.is_empty() { name.to_owned() } else { format!("{scope}::{name}") };
            if self.definitions.contains_key(&full) {
                return Some(full);
            }
            if scope.is_empty() {
                return None;
            }
            scope = scope.rsplit_once("::").map_or("", |(outer, _)| outer);
        }
    }
}

fn arrays(shape: Shape, lengths: &[usize]) -> Shape {
    lengths.iter().rev().fold(shape, |shape, length| Shape::List(Box::new(shape), Size::Fixed(*length)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const TEXT: &str = r#"
================================================================================
IDL: a/msg/Status
// generated
#include "b/msg/Inner.idl"
module a {
  module msg {
    typedef double double__9[9];
    module Status_Constants {
      @verbatim (language="comment", text="drive; (forward)")
      const uint8 DRIVE = 2;
    };
    @verbatim (language="comment", text= "one" "two")
    struct Status {
      @default (value=TRUE)
      boolean on;
      unsigned long long count;
      sequence<string<8>, 4> words;
      double__9 k;
      float pair[2];
      b::msg::Inner inner;
      @key
      uint8 report;
    };
  };
};
================================================================================
IDL: b/msg/Inner
module b { module msg { struct Inner { long x, y; }; }; };
"#;

    #[test]
    fn every_kind_of_member_is_understood() {
        let shape = parse("a/msg/Status", TEXT).unwrap();
        let kinds: Vec<_> = shape.fields.iter().map(|(name, shape)| (name.as_str(), shape.clone())).collect();
        assert_eq!(kinds[1], ("count", Shape::Number(Kind::U64)));
        assert_eq!(kinds[2], ("words", Shape::List(Box::new(Shape::Text), Size::Counted)));
        assert_eq!(kinds[3], ("k", Shape::List(Box::new(Shape::Number(Kind::F64)), Size::Fixed(9))));
        assert_eq!(kinds[4], ("pair", Shape::List(Box::new(Shape::Number(Kind::F32)), Size::Fixed(2))));
        assert!(matches!(&kinds[5].1, Shape::Message(inner) if inner.fields.len() == 2));
        assert_eq!(*shape.constants, [("DRIVE".to_owned(), 2)]);
    }

    #[test]
    fn types_without_end_are_an_error() {
        assert!(parse("M", "struct M { M m; };").is_err());
        assert!(parse("M", "typedef M M; struct N { M m; };").is_err());
        assert!(parse("M", "typedef sequence<M> M; ").is_err());
        assert!(parse("M", &"sequence<".repeat(100_000)).is_err());
        assert!(parse("M", "union U switch (long) {};").is_err());
        assert!(parse("M", "struct M { long x; ").is_err());
    }
}
