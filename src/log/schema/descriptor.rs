//! Protobuf message types from the descriptors that a log stores with them.
//!
//! Only what reading needs is kept, and nothing of it is believed: names that lead nowhere are an error, whatever else the descriptors
//! hold is passed over. Source: `google/protobuf/descriptor.proto`.

use crate::log::schema::shape::Names;
use crate::log::value::Raw;
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{DescriptorProto, EnumDescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

/// Messages declared within each other at most.
const MAX_DEPTH: usize = 64;

/// A message type, among all types of its schema.
#[derive(Debug, Clone)]
pub(crate) struct ProtobufMessage {
    types: Arc<Vec<ProtobufStructure>>,
    index: usize,
}

#[derive(Debug)]
struct ProtobufStructure {
    full_name: String,
    fields: Vec<ProtobufField>,
}

/// A field of a message type.
#[derive(Debug)]
pub(crate) struct ProtobufField {
    pub name: String,
    json_name: String,
    pub number: u32,
    pub kind: ProtobufKind,
    /// A list or a map.
    pub repeated: bool,
    pub is_map: bool,
    /// The value that a message without it has; `None` when it has none then.
    pub absent: Option<Raw<'static>>,
}

/// What a field holds.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum ProtobufKind {
    /// A message or a group: its place among the types.
    Message(usize),
    /// An enumeration: its names and numbers.
    Enum(Names),
    Scalar(Type),
}

/// What a name means.
enum NamedDescriptor<'d> {
    Message(usize),
    Enum(&'d EnumDescriptorProto),
}

/// Every declaration of a schema, by full name.
#[derive(Default)]
struct Declared<'d> {
    names: HashMap<String, NamedDescriptor<'d>>,
    /// Full name, declaration, and whether its file is of proto3.
    messages: Vec<(String, &'d DescriptorProto, bool)>,
}

impl ProtobufMessage {
    /// The message `name` of the schema whose descriptors (a `FileDescriptorSet`) are `data`.
    ///
    /// # Errors
    /// What is wrong with the descriptors.
    pub(crate) fn parse(name: &str, data: &[u8]) -> Result<Self, String> {
        let set = <FileDescriptorSet as prost::Message>::decode(data).map_err(|error| error.to_string())?;
        let mut declared = Declared::default();
        set.file.iter().try_for_each(|file| declared.file(file))?;
        let mut enums = HashMap::new();
        let types = declared
            .messages
            .iter()
            .map(|(full_name, message, proto3)| {
                let fields = message.field.iter().map(|field| declared.field(full_name, field, *proto3, &mut enums));
                Ok(ProtobufStructure { full_name: full_name.clone(), fields: fields.collect::<Result<_, String>>()? })
            })
            .collect::<Result<_, String>>()?;
        match declared.names.get(name.trim_start_matches('.')) {
            Some(NamedDescriptor::Message(index)) => Ok(Self { types: Arc::new(types), index: *index }),
            _ => Err("its descriptors do not hold that message".into()),
        }
    }

    /// Its place among the types of its schema.
    pub(crate) fn index(&self) -> usize {
        self.index
    }

    pub(crate) fn full_name(&self) -> &str {
        &self.types[self.index].full_name
    }

    pub(crate) fn fields(&self) -> &[ProtobufField] {
        &self.types[self.index].fields
    }

    /// The field of that name, as declared or as JSON spells it.
    pub(crate) fn field(&self, name: &str) -> Option<&ProtobufField> {
        let fields = self.fields();
        fields.iter().find(|field| field.name == name).or_else(|| fields.iter().find(|field| field.json_name == name))
    }

    /// The numbers named for the value that `fields` lead to.
    pub(crate) fn names<'s>(&self, fields: &mut impl Iterator<Item = &'s str>) -> Names {
        match fields.next().and_then(|name| self.field(name)).map(|field| &field.kind) {
            Some(ProtobufKind::Message(inner)) => self.other(*inner).names(fields),
            Some(ProtobufKind::Enum(names)) => names.clone(),
            _ => Names::default(),
        }
    }

    /// The type that [`ProtobufKind::ProtobufMessage`] names.
    pub(crate) fn other(&self, index: usize) -> Self {
        Self { types: self.types.clone(), index }
    }
}

impl<'d> Declared<'d> {
    fn file(&mut self, file: &'d FileDescriptorProto) -> Result<(), String> {
        let package = file.package().to_owned();
        file.enum_type.iter().for_each(|kind| self.enumeration(&package, kind));
        let proto3 = file.syntax() == "proto3";
        file.message_type.iter().try_for_each(|message| self.message(&package, message, proto3, 0))
    }

    fn enumeration(&mut self, within: &str, kind: &'d EnumDescriptorProto) {
        self.names.entry(full(within, kind.name())).or_insert(NamedDescriptor::Enum(kind));
    }

    fn message(&mut self, within: &str, message: &'d DescriptorProto, proto3: bool, depth: usize) -> Result<(), String> {
        if depth > MAX_DEPTH {
            return Err(format!("messages are declared within each other more than {MAX_DEPTH} deep"));
        }
        let name = full(within, message.name());
        self.names.entry(name.clone()).or_insert(NamedDescriptor::Message(self.messages.len()));
        message.enum_type.iter().for_each(|kind| self.enumeration(&name, kind));
        self.messages.push((name.clone(), message, proto3));
        message.nested_type.iter().try_for_each(|inner| self.message(&name, inner, proto3, depth + 1))
    }

    /// What `name` means in the message `within`: the innermost declaration counts; a leading dot says that the name is complete.
    fn find(&self, within: &str, name: &str) -> Result<&NamedDescriptor<'d>, String> {
        if let Some(name) = name.strip_prefix('.') {
            return self.names.get(name).ok_or_else(|| format!("it has no type {name}"));
        }
        let mut scope = within;
        loop {
            if let Some(found) = self.names.get(&full(scope, name)) {
                return Ok(found);
            }
            if scope.is_empty() {
                return Err(format!("it has no type {name}"));
            }
            scope = scope.rsplit_once('.').map_or("", |(outer, _)| outer);
        }
    }

    fn field(
        &self,
        within: &str,
        field: &FieldDescriptorProto,
        proto3: bool,
        enums: &mut HashMap<*const EnumDescriptorProto, Names>,
    ) -> Result<ProtobufField, String> {
        let name = field.name().to_owned();
        let number = u32::try_from(field.number()).ok().filter(|number| (1..1 << 29).contains(number));
        let number = number.ok_or_else(|| format!("field {name} of {within} has the number {}", field.number()))?;
        let unknown = || format!("field {name} of {within} has no type that is known");
        let mut is_map = false;
        let kind = match field.r#type.map(Type::try_from) {
            Some(Ok(kind)) if !matches!(kind, Type::Message | Type::Group | Type::Enum) => ProtobufKind::Scalar(kind),
            Some(Err(_)) => return Err(unknown()),
            _ => match self.find(within, field.type_name.as_deref().ok_or_else(unknown)?)? {
                NamedDescriptor::Message(index) => {
                    is_map = self.messages[*index].1.options.as_ref().is_some_and(prost_types::MessageOptions::map_entry);
                    ProtobufKind::Message(*index)
                }
                NamedDescriptor::Enum(kind) => {
                    let list = || kind.value.iter().map(|value| (value.name().to_owned(), i64::from(value.number()))).collect();
                    ProtobufKind::Enum(enums.entry(std::ptr::from_ref(*kind)).or_insert_with(|| Arc::new(list())).clone())
                }
            },
        };
        let repeated = field.label() == Label::Repeated;
        let alone = field.oneof_index.is_none() && !field.proto3_optional() && !repeated;
        let absent = match &field.default_value {
            Some(text) if alone => own_default(&kind, text),
            None if alone && proto3 => default(&kind),
            _ => None,
        };
        let json_name = field.json_name.clone().unwrap_or_else(|| camel(&name));
        Ok(ProtobufField { json_name, number, kind, repeated, is_map: is_map && repeated, absent, name })
    }
}

fn full(within: &str, name: &str) -> String {
    if within.is_empty() { name.to_owned() } else { format!("{within}.{name}") }
}

/// A name as JSON spells it: `speed_mps` becomes `speedMps`.
fn camel(name: &str) -> String {
    let mut words = name.split('_');
    let first = words.next().unwrap_or_default().to_owned();
    words.fold(first, |whole, word| {
        let mut letters = word.chars();
        whole + &letters.next().map(|letter| letter.to_ascii_uppercase()).into_iter().chain(letters).collect::<String>()
    })
}

/// Zero, the empty text, the first of an enumeration's values.
fn default(kind: &ProtobufKind) -> Option<Raw<'static>> {
    Some(match kind {
        ProtobufKind::Message(_) | ProtobufKind::Scalar(Type::Bytes) => return None,
        ProtobufKind::Enum(values) => Raw::Integer(values.first().map_or(0, |(_, number)| *number)),
        ProtobufKind::Scalar(Type::Double | Type::Float) => Raw::Number(0.0),
        ProtobufKind::Scalar(Type::String) => Raw::Text(Cow::Borrowed("")),
        ProtobufKind::Scalar(_) => Raw::Integer(0),
    })
}

/// The default that a field of proto2 declares.
fn own_default(kind: &ProtobufKind, text: &str) -> Option<Raw<'static>> {
    Some(match kind {
        ProtobufKind::Message(_) | ProtobufKind::Scalar(Type::Bytes) => return None,
        ProtobufKind::Enum(values) => Raw::Integer(values.iter().find(|(name, _)| name == text)?.1),
        ProtobufKind::Scalar(Type::Double | Type::Float) => Raw::Number(text.parse().ok()?),
        ProtobufKind::Scalar(Type::String) => Raw::Text(Cow::Owned(text.to_owned())),
        ProtobufKind::Scalar(Type::Bool) => Raw::Integer(i64::from(text == "true")),
        ProtobufKind::Scalar(_) => text.parse().map(Raw::Integer).or_else(|_| text.parse().map(Raw::unsigned)).ok()?,
    })
}
