//! A table as generated code stores it: floating-point numbers or whole counts of 16 bits, in the user's units.

use crate::export::number::Precision;
use crate::export::user_unit::UserUnit;
use crate::export::{Error, ExportSettings, MapSource, Result};
use crate::map::{RawUnit, TorqueTable};

/// The numbers of an axis, or of the values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StoredNumbers {
    /// Literals, in C and Rust alike; without the suffix of a type.
    pub(crate) literals: Vec<String>,
    /// Value of a count and value of count 0; `None` for floating-point numbers.
    pub(crate) unit: Option<(f64, f64)>,
    bytes: Vec<u8>,
}

/// A table as it is stored.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StoredTable {
    /// Speed breaks.
    pub(crate) speed: StoredNumbers,
    /// Breaks of the desired acceleration.
    pub(crate) accel: StoredNumbers,
    /// Torques, one row per speed.
    pub(crate) torque: StoredNumbers,
    /// CRC-32 (polynomial 0x04C11DB7 reflected, start and final inversion, as in Ethernet and zlib) over speed breaks, acceleration breaks and
    /// values in this order, every number with its least significant byte first.
    pub(crate) crc32: u32,
}

impl StoredTable {
    /// The table of a map.
    ///
    /// # Errors
    /// Whole counts of a map that was not inverted with raw units.
    pub(crate) fn new(source: &MapSource, table: &TorqueTable, settings: &ExportSettings) -> Result<Self> {
        let raw = source.table2.raw.unwrap_or_default();
        let numbers = |what, values: &[f64], raw: Option<RawUnit>, unit: Option<&UserUnit>| {
            if settings.int16 { counts(what, values, raw, unit) } else { Ok(reals(values, settings.precision, unit)) }
        };
        let units = &settings.units;
        let speed = numbers("speed", table.speed_mps().breaks(), raw.speed_mps, units.speed.as_ref())?;
        let accel = numbers("acceleration", table.accel_mps2().breaks(), raw.accel_mps2, None)?;
        let torque = numbers("torque", table.values(), raw.torque_nm, units.torque.as_ref())?;
        let crc32 = crc32fast::hash(&[speed.bytes.as_slice(), &accel.bytes, &torque.bytes].concat());
        Ok(Self { speed, accel, torque, crc32 })
    }

    /// Bytes of its numbers.
    pub(crate) fn bytes(&self) -> usize {
        [&self.speed, &self.accel, &self.torque].into_iter().map(|numbers| numbers.bytes.len()).sum()
    }
}

fn reals(values: &[f64], precision: Precision, unit: Option<&UserUnit>) -> StoredNumbers {
    let values: Vec<f64> = values.iter().map(|v| unit.map_or(*v, |unit| unit.number(*v))).collect();
    StoredNumbers {
        literals: values.iter().map(|v| precision.literal(*v)).collect(),
        unit: None,
        bytes: values.iter().flat_map(|v| precision.bytes(*v)).collect(),
    }
}

fn counts(what: &'static str, values: &[f64], raw: Option<RawUnit>, unit: Option<&UserUnit>) -> Result<StoredNumbers> {
    let raw = raw.ok_or(Error::NotRaw { what })?;
    // a value that is not that of its count was not made with this unit
    let count =
        |value: f64| raw.raw(value).filter(|count| raw.value(*count).to_bits() == (value + 0.0).to_bits()).ok_or(Error::NotRaw { what });
    let counts = values.iter().map(|v| count(*v)).collect::<Result<Vec<i16>>>()?;
    let (scale, offset) = unit.map_or((raw.scale, raw.offset), |u| (raw.scale / u.scale, (raw.offset - u.offset) / u.scale));
    Ok(StoredNumbers {
        literals: counts.iter().map(i16::to_string).collect(),
        unit: Some((scale, offset)),
        bytes: counts.iter().flat_map(|count| count.to_le_bytes()).collect(),
    })
}
