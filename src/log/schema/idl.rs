//! ROS 2 interface definitions in OMG IDL (ros2idl schemas): modules, structures, typedefs, enumerations, constants.
//!
//! Only what ROS 2 generates is understood; unions, maps and bit sets are an error. Parsed without recursion into the text, so that no
//! schema exhausts the stack. Source: OMG IDL 4.2, and <https://design.ros2.org/articles/idl_interface_definition.html>.

pub(crate) mod definition;
mod parser;

use crate::log::schema::idl::definition::{Definitions, IdlDefinition, IdlName};
use crate::log::schema::shape::{Kind, MAX_DEPTH, Shape, Size, Structure};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Parses a definition into the shape of the message `name` (`pkg/msg/Name`).
///
/// # Errors
/// What cannot be parsed, or the type that is missing.
pub(crate) fn parse(name: &str, text: &str) -> Result<Arc<Structure>, String> {
    IdlBuilder { definitions: parser::read(text)?, built: BTreeMap::new() }.structure(&name.replace('/', "::"), 0)
}

struct IdlBuilder {
    definitions: Definitions,
    built: BTreeMap<String, Arc<Structure>>,
}

impl IdlBuilder {
    fn structure(&mut self, full: &str, depth: usize) -> Result<Arc<Structure>, String> {
        if let Some(built) = self.built.get(full) {
            return Ok(built.clone());
        }
        if depth > MAX_DEPTH {
            return Err(format!("messages are nested more than {MAX_DEPTH} deep, or contain themselves"));
        }
        let Some(IdlDefinition::Structure(members)) = self.definitions.types.get(full).cloned() else {
            return Err(format!("it does not hold the type {}", full.replace("::", "/")));
        };
        let mut fields = Vec::with_capacity(members.len());
        for member in members {
            let shape = self.shape(&member.kind, depth)?;
            fields.push((member.name, arrays(shape, &member.lengths)));
        }
        let constants = Arc::new(self.definitions.constants.get(&format!("{full}_Constants")).cloned().unwrap_or_default());
        let built = Arc::new(Structure { name: full.replace("::", "/"), fields, constants });
        self.built.insert(full.to_owned(), built.clone());
        Ok(built)
    }

    fn shape(&mut self, kind: &IdlName, depth: usize) -> Result<Shape, String> {
        if depth > 2 * MAX_DEPTH {
            return Err("types refer to each other without end".into());
        }
        match kind {
            IdlName::Scalar(shape) => Ok(shape.clone()),
            IdlName::Sequence(of) => Ok(Shape::List(Box::new(self.shape(of, depth + 1)?), Size::Counted)),
            IdlName::Type { name, scope } => {
                let full = self.find(name, scope).ok_or_else(|| format!("it does not hold the type {name}"))?;
                match self.definitions.types.get(&full).cloned() {
                    Some(IdlDefinition::Alias(kind, lengths)) => Ok(arrays(self.shape(&kind, depth + 1)?, &lengths)),
                    Some(IdlDefinition::Enumeration) => Ok(Shape::Number(Kind::U32)),
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
            if self.definitions.types.contains_key(&full) {
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
