//! Why a path cannot be extracted from a schema.

/// Why a path cannot be compiled for a schema.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the fields are what the message says
pub enum PlanError {
    #[error("there is no field {field:?} in {within}; it has {}", known.join(", "))]
    NoField { field: String, within: String, known: Vec<String> },
    #[error("{field} is not an array, so nothing can be picked from it")]
    NotAnArray { field: String },
    #[error("{field} is an array: pick one element, for example {field}[0]")]
    WholeArray { field: String },
    #[error("{field} is a message of its own: go on to one of {}", known.join(", "))]
    WholeMessage { field: String, known: Vec<String> },
    #[error("it picks several values; a signal needs one")]
    ManyValues,
    #[error("behind a slice that picks several elements there may be neither another one nor a filter")]
    ListWithin,
    #[error("the schema is too large to compile")]
    TooLarge,
}
