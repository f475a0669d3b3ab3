//! Reads single fields of single messages with a compiled plan, for programs that already have the payloads.

use crate::log::extract::extractor::Extractor;
use crate::log::extract::extractor::taken::Taken;
use crate::log::extractor_error::PlanError;
use crate::log::file::structure::Schema;
use crate::log::path::MessagePath;
use crate::log::schema::Layout;
use crate::log::schema_error::SchemaError;
use crate::log::value::Raw;

/// Reads selected fields of the messages of one schema, without building the messages.
///
/// ```
/// use pivot_cal::internals::FieldReader;
/// let schema = ("pkg/msg/Pair", "ros2msg", b"float32 a\nfloat64[] b\n".as_slice());
/// let reader = FieldReader::new("cdr", Some(schema), &["/t.a".parse()?, "/t.b[-1]".parse()?])?;
/// let payload = [&[0, 1, 0, 0], &1.5_f32.to_le_bytes()[..], &1_u32.to_le_bytes(), &2.5_f64.to_le_bytes()].concat();
/// let mut values = [None; 2];
/// assert!(reader.read(&payload, &mut values));
/// assert_eq!(values, [Some(1.5), Some(2.5)]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct FieldReader {
    plan: Extractor,
}

/// Why fields of a schema cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The schema cannot be used.
    #[error(transparent)]
    Schema(#[from] SchemaError),
    /// A path leads to no value.
    #[error("path {path}: {source}")]
    Path {
        /// The path as written.
        path: String,
        /// Why not.
        source: PlanError,
    },
}

impl FieldReader {
    /// Compiles `paths`; their topics are ignored. `schema`: name, encoding and data, as MCAP stores them.
    ///
    /// # Errors
    /// A schema that cannot be read, or the first path that does not lead to a value.
    pub fn new(message_encoding: &str, schema: Option<(&str, &str, &[u8])>, paths: &[MessagePath]) -> Result<Self, FieldError> {
        let schema =
            schema.map(|(name, encoding, data)| Schema { name: name.to_owned(), encoding: encoding.to_owned(), data: data.to_vec() });
        let layout = Layout::parse(message_encoding, schema.as_ref())?;
        let all: Vec<&MessagePath> = paths.iter().collect();
        let plan =
            Extractor::compile(&layout, &all).map_err(|(index, source)| FieldError::Path { path: paths[index].to_string(), source })?;
        Ok(Self { plan })
    }

    /// Puts the numbers into `values`, one per path; `None` where the message holds no value or a string. Returns `false` if the payload
    /// does not fit the schema.
    pub fn read(&self, payload: &[u8], values: &mut [Option<f64>]) -> bool {
        let mut taken = Taken::default();
        self.read_with(payload, &mut taken, values)
    }

    /// Like [`FieldReader::read`], for each of `payloads`. `visit` receives the values, or `None` for a payload that does not fit.
    pub fn read_all<'a>(&self, payloads: impl IntoIterator<Item = &'a [u8]>, mut visit: impl FnMut(Option<&[Option<f64>]>)) {
        let mut taken = Taken::default();
        let mut values = vec![None; self.plan.paths()];
        for payload in payloads {
            let fits = self.read_with(payload, &mut taken, &mut values);
            visit(fits.then_some(&values));
        }
    }

    fn read_with<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>, values: &mut [Option<f64>]) -> bool {
        if self.plan.decode(payload, taken).is_none() {
            return false;
        }
        for (slot, value) in values.iter_mut().enumerate().take(self.plan.paths()) {
            *value = match taken.get(slot) {
                Raw::Number(value) => Some(*value),
                Raw::Integer(value) => Some(*value as f64),
                Raw::Text(_) | Raw::Missing => None,
            };
        }
        true
    }
}
