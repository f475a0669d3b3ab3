//! Reasons why a path cannot be extracted from a schema.

/// The reason why a path cannot be compiled for a schema.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum PlanError {
    #[error("there is no field {field:?} in {within}; it has {}", known.join(", "))]
    NoField { field: String, within: String, known: Vec<String> },
    #[error("{field} is not an array, so no element can be picked from it")]
    NotAnArray { field: String },
    #[error("{field} is an array: pick one element, for example {field}[0]")]
    WholeArray { field: String },
    #[error("{field} has fields: name one of them: {}", known.join(", "))]
    WholeMessage { field: String, known: Vec<String> },
    #[error("it picks several values; a signal needs one")]
    ManyValues,
    #[error("a slice that picks several elements cannot be followed by another slice or a filter")]
    ListWithin,
    #[error("the schema is too large to compile")]
    TooLarge,
}
