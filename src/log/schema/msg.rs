//! ROS message definitions (`.msg` files joined together, as ros2msg and ros1msg schemas hold them).
//!
//! Sources: <https://mcap.dev/spec/registry#ros2msg>, <https://wiki.ros.org/msg>.

use crate::log::schema::shape::{Kind, MAX_DEPTH, Names, Shape, Size, Structure};
use re_ros_msg::message_spec::{ArraySize, BuiltInType, ComplexType, MessageSpecification, Type};
use re_ros_msg::{MessageSchema, is_schema_separator};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Arc;

/// Which generation of ROS.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Dialect {
    Ros1,
    Ros2,
}

/// The field that the parser adds to a message without fields; ROS 1 does not.
const PADDING: &str = "structure_needs_at_least_one_member";

/// Parses a definition into the shape of its main message.
///
/// # Errors
/// What cannot be parsed, or the type that is missing.
pub(crate) fn parse(name: &str, text: &str, dialect: Dialect) -> Result<Arc<Structure>, String> {
    let (layout_only, constants) = split_constants(text);
    let schema = MessageSchema::parse(name, &layout_only).map_err(|error| format!("{error:#}"))?;
    let mut builder = MsgBuilder { dialect, specs: BTreeMap::new(), constants, built: BTreeMap::new() };
    for spec in &schema.dependencies {
        builder.specs.entry(short(&spec.name)).or_insert(spec);
    }
    builder.structure(&schema.spec, 0)
}

/// `pkg/msg/Name` and `pkg/Name` are the same type.
fn short(name: &str) -> String {
    match name.split('/').collect::<Vec<_>>()[..] {
        [package, _, name] => format!("{package}/{name}"),
        _ => name.to_owned(),
    }
}

/// Numbers that a message type names, by type name; the main type's name is empty.
type Constants = BTreeMap<String, Vec<(String, i64)>>;

/// Takes constants and default values, which do not change the layout, out of a definition: ROS 1 spells them in ways that the parser
/// refuses, and an unreadable default is no reason to lose a field.
fn split_constants(text: &str) -> (String, Constants) {
    let mut rest = String::with_capacity(text.len());
    let mut constants = Constants::new();
    let mut section = String::new();
    for line in text.lines() {
        if is_schema_separator(line) {
            section.clear();
            let _ = writeln!(rest, "{line}");
            continue;
        }
        if let Some(name) = line.trim().strip_prefix("MSG:") {
            section = short(name.trim());
            let _ = writeln!(rest, "MSG: {}\n", name.trim());
            continue;
        }
        // a comment sign inside a default's quotes cuts only the default
        let code = line.split('#').next().unwrap_or_default().trim();
        let Some((kind, behind)) = code.split_once(char::is_whitespace) else {
            if !code.is_empty() {
                let _ = writeln!(rest, "{code}"); // half a line: the parser says what is wrong
            }
            continue;
        };
        // `<=` belongs to a bound of the type: a constant's sign comes behind the name
        let word = behind.trim_start().split(|c: char| c.is_whitespace() || c == '=').next().unwrap_or_default();
        let value = behind.trim_start()[word.len()..].trim();
        if let Some(value) = value.strip_prefix('=') {
            if let Some(number) = integer(value.trim()) {
                constants.entry(section.clone()).or_default().push((word.to_owned(), number));
            }
        } else {
            let _ = writeln!(rest, "{kind} {word}");
        }
    }
    (rest, constants)
}

fn integer(text: &str) -> Option<i64> {
    text.strip_prefix("0x").map_or_else(|| text.parse().ok(), |digits| i64::from_str_radix(digits, 16).ok())
}

struct MsgBuilder<'a> {
    dialect: Dialect,
    specs: BTreeMap<String, &'a MessageSpecification>,
    constants: Constants,
    built: BTreeMap<String, Arc<Structure>>,
}

impl MsgBuilder<'_> {
    fn structure(&mut self, spec: &MessageSpecification, depth: usize) -> Result<Arc<Structure>, String> {
        if depth > MAX_DEPTH {
            return Err(format!("messages are nested more than {MAX_DEPTH} deep, or contain themselves"));
        }
        let package = spec.name.split('/').next().unwrap_or_default().to_owned();
        let mut fields = Vec::with_capacity(spec.fields.len());
        for field in &spec.fields {
            if self.dialect == Dialect::Ros1 && field.name == PADDING {
                continue;
            }
            fields.push((field.name.clone(), self.shape(&field.ty, &package, depth)?));
        }
        let key = if depth == 0 { String::new() } else { short(&spec.name) };
        Ok(Arc::new(Structure { name: spec.name.clone(), fields, constants: Arc::new(self.constants.remove(&key).unwrap_or_default()) }))
    }

    fn shape(&mut self, kind: &Type, package: &str, depth: usize) -> Result<Shape, String> {
        Ok(match kind {
            Type::BuiltIn(kind) => self.builtin(kind),
            Type::Complex(name) => self.message(name, package, depth)?,
            Type::Array { ty, size } => {
                let size = match size {
                    ArraySize::Fixed(length) => Size::Fixed(*length),
                    ArraySize::Bounded(_) | ArraySize::Unbounded => Size::Counted,
                };
                Shape::List(Box::new(self.shape(ty, package, depth)?), size)
            }
        })
    }

    fn builtin(&self, kind: &BuiltInType) -> Shape {
        let ros1 = self.dialect == Dialect::Ros1;
        Shape::Number(match kind {
            BuiltInType::Bool => Kind::Bool,
            // ROS 1 has `byte` signed and `char` unsigned, ROS 2 has both unsigned
            BuiltInType::Byte if ros1 => Kind::I8,
            BuiltInType::Byte | BuiltInType::Char | BuiltInType::UInt8 => Kind::U8,
            BuiltInType::Int8 => Kind::I8,
            BuiltInType::Int16 => Kind::I16,
            BuiltInType::UInt16 => Kind::U16,
            BuiltInType::Int32 => Kind::I32,
            BuiltInType::UInt32 => Kind::U32,
            BuiltInType::Int64 => Kind::I64,
            BuiltInType::UInt64 => Kind::U64,
            BuiltInType::Float32 => Kind::F32,
            BuiltInType::Float64 => Kind::F64,
            BuiltInType::String(_) => return Shape::Text,
            BuiltInType::WString(_) => return Shape::WideText,
        })
    }

    fn message(&mut self, kind: &ComplexType, package: &str, depth: usize) -> Result<Shape, String> {
        let key = match kind {
            ComplexType::Absolute { package, name } => short(&format!("{package}/{name}")),
            ComplexType::Relative { name } => {
                if self.dialect == Dialect::Ros1 && (name == "time" || name == "duration") {
                    let seconds = if name == "time" { Kind::U32 } else { Kind::I32 };
                    let fields = vec![("sec".to_owned(), Shape::Number(seconds)), ("nsec".to_owned(), Shape::Number(seconds))];
                    return Ok(Shape::Message(Arc::new(Structure { name: name.clone(), fields, constants: Names::default() })));
                }
                let local = format!("{package}/{name}");
                // a bare `Header` means std_msgs/Header; some writers leave the package out altogether
                [local.clone(), format!("std_msgs/{name}"), name.clone()]
                    .into_iter()
                    .find(|key| self.specs.contains_key(key))
                    .unwrap_or(local)
            }
        };
        if let Some(built) = self.built.get(&key) {
            return Ok(Shape::Message(built.clone()));
        }
        let Some(spec) = self.specs.get(&key).copied() else {
            return well_known(&key).map(Shape::Message).ok_or_else(|| format!("it does not hold the type {key}"));
        };
        let built = self.structure(spec, depth + 1)?;
        self.built.insert(key, built.clone());
        Ok(Shape::Message(built))
    }
}

/// Types so common that some writers leave them out of the schema.
fn well_known(key: &str) -> Option<Arc<Structure>> {
    if !matches!(key, "builtin_interfaces/Time" | "builtin_interfaces/Duration") {
        return None;
    }
    let fields = vec![("sec".to_owned(), Shape::Number(Kind::I32)), ("nanosec".to_owned(), Shape::Number(Kind::U32))];
    Some(Arc::new(Structure { name: key.to_owned(), fields, constants: Names::default() }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn constants_and_defaults_do_not_move_the_fields() {
        let text =
            "uint8 DRIVE=2\nstring lower_case = \"a=b # c\"\nint32 count 5 # five\nstring<=32[] faults [\"a\", \"b\"]\nfloat32[3] a\n";
        let shape = parse("pkg/msg/Thing", text, Dialect::Ros2).unwrap();
        assert_eq!(*shape.constants, [("DRIVE".to_owned(), 2)]);
        assert_eq!(shape.fields.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["count", "faults", "a"]);
        assert_eq!(shape.fields[2].1, Shape::List(Box::new(Shape::Number(Kind::F32)), Size::Fixed(3)));
    }

    #[test]
    fn nested_types_are_found_by_long_short_and_bare_names() {
        let text = "Header header\nother/msg/Inner inner\n===\nMSG: std_msgs/msg/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n===\nMSG: other/Inner\nfloat64 x\n";
        let shape = parse("pkg/msg/Thing", text, Dialect::Ros2).unwrap();
        let paths: Vec<_> = crate::log::schema::leaves::leaves(&shape).into_iter().map(|leaf| leaf.path).collect();
        assert_eq!(paths, [".header.frame_id", ".inner.x", ".header.stamp.sec", ".header.stamp.nanosec"]);
    }

    #[test]
    fn a_type_that_contains_itself_is_an_error() {
        let text = "a/B b\n===\nMSG: a/B\na/B[] b\n";
        assert!(parse("a/A", text, Dialect::Ros2).unwrap_err().contains("nested"));
    }

    #[test]
    fn a_missing_type_is_named() {
        assert!(parse("a/A", "a/Gone b\n", Dialect::Ros2).unwrap_err().contains("a/Gone"));
    }
}
