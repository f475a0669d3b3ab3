//! What is wrong with a schema.

/// Why a channel cannot be decoded.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the fields are what the message says
pub enum SchemaError {
    #[error(
        "messages in {message} with a schema in {schema} cannot be decoded; known: cdr with ros2msg or ros2idl, ros1 with ros1msg, protobuf, json"
    )]
    Unsupported { message: String, schema: String },
    #[error("the channel has no schema, and its encoding {message} needs one")]
    Missing { message: String },
    #[error("the schema {name} cannot be read: {reason}")]
    Broken { name: String, reason: String },
}
