//! The layout of a channel's messages: schemas of every encoding, parsed into a [`Layout`].

mod descriptor;
mod idl;
mod leaves;
mod msg;
mod shape;

use crate::log::schema_error::SchemaError;
pub(crate) use descriptor::{ProtobufField, ProtobufKind, ProtobufMessage};
pub(crate) use leaves::{LONGEST_PATH, Leaf, LeafKind};
pub(crate) use shape::{Kind, Names, Shape, Size, Structure};

use crate::log::file::structure::Schema;
use crate::log::path::PathStep;
use std::sync::Arc;

/// Layout of a channel's payload.
#[derive(Debug, Clone)]
pub(crate) enum Layout {
    /// Common data representation, as written by ROS 2.
    Cdr(Arc<Structure>),
    /// ROS 1: like CDR, without alignment.
    Ros1(Arc<Structure>),
    Protobuf(ProtobufMessage),
    /// JSON describes itself.
    Json,
}

impl Layout {
    /// Parses the schema of a channel.
    ///
    /// # Errors
    /// The encoding is not known, or the schema is missing or broken.
    pub(crate) fn parse(message_encoding: &str, schema: Option<&Schema>) -> Result<Self, SchemaError> {
        let broken = |schema: &Schema, reason: String| SchemaError::Broken { name: schema.name.clone(), reason };
        let text = |schema: &Schema| match std::str::from_utf8(&schema.data) {
            Ok(text) if !text.trim().is_empty() => Ok(text.to_owned()),
            Ok(_) => Err(broken(schema, "it is empty".into())),
            Err(error) => Err(broken(schema, error.to_string())),
        };
        if message_encoding == "json" {
            return Ok(Self::Json);
        }
        let Some(schema) = schema else {
            return Err(SchemaError::Missing { message: message_encoding.to_owned() });
        };
        match (message_encoding, schema.encoding.as_str()) {
            ("cdr", "ros2msg") => {
                msg::parse(&schema.name, &text(schema)?, msg::Dialect::Ros2).map(Self::Cdr).map_err(|reason| broken(schema, reason))
            }
            ("cdr", "ros2idl") => idl::parse(&schema.name, &text(schema)?).map(Self::Cdr).map_err(|reason| broken(schema, reason)),
            ("ros1", "ros1msg") => {
                msg::parse(&schema.name, &text(schema)?, msg::Dialect::Ros1).map(Self::Ros1).map_err(|reason| broken(schema, reason))
            }
            ("protobuf", "protobuf") => {
                ProtobufMessage::parse(&schema.name, &schema.data).map(Self::Protobuf).map_err(|reason| broken(schema, reason))
            }
            (message, encoding) => Err(SchemaError::Unsupported { message: message.to_owned(), schema: encoding.to_owned() }),
        }
    }

    /// Every place of a message that holds a single value, for suggestions and detection. JSON has none: its messages are used.
    pub(crate) fn leaves(&self) -> Vec<Leaf> {
        match self {
            Self::Cdr(structure) | Self::Ros1(structure) => leaves::leaves(structure),
            Self::Protobuf(message) => leaves::protobuf_leaves(message),
            Self::Json => Vec::new(),
        }
    }

    /// The numbers that the schema names for the value at the end of `steps`; none where it names none.
    pub(crate) fn names(&self, steps: &[PathStep]) -> Names {
        let mut fields = steps.iter().filter_map(|step| if let PathStep::Field(name) = step { Some(name.as_str()) } else { None });
        match self {
            Self::Cdr(structure) | Self::Ros1(structure) => structure.names(&mut fields),
            Self::Protobuf(message) => message.names(&mut fields),
            Self::Json => Names::default(),
        }
    }
}
