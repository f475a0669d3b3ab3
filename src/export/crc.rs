//! Checksum of a table as the generated code computes it.

use crate::export::Precision;
use crate::map::TorqueTable;

/// CRC-32 (polynomial 0x04C11DB7 reflected, start and final inversion, as in Ethernet and zlib) over speed breaks, acceleration breaks and
/// values in this order, every number of `precision` with its least significant byte first.
pub(crate) fn crc32(table: &TorqueTable, precision: Precision) -> u32 {
    let numbers = table.speed_mps().breaks().iter().chain(table.accel_mps2().breaks()).chain(table.values());
    let bytes: Vec<u8> = numbers.flat_map(|v| precision.bytes(*v)).collect();
    crc32fast::hash(&bytes)
}
