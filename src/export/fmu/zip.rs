//! A ZIP archive without compression and without times: the same entries give the same bytes.
//!
//! Source: *.ZIP File Format Specification*, PKWARE, version 6.3, §4.3.

/// Version of the format that is needed to extract: 2.0, folders.
const VERSION: u16 = 20;
/// 1980-01-01, the first day that the format has.
const DATE: u16 = 0x21;
/// Names are UTF-8.
const FLAGS: u16 = 1 << 11;

/// The archive of entries: path with `/`, and content.
pub(crate) fn archive(entries: &[(String, Vec<u8>)]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (path, content) in entries {
        let at = bytes.len() as u32;
        let fields = |out: &mut Vec<u8>| {
            for field in [VERSION, FLAGS, 0, 0, DATE] {
                out.extend(field.to_le_bytes());
            }
            let size = content.len() as u32;
            for field in [crc32fast::hash(content), size, size] {
                out.extend(field.to_le_bytes());
            }
            out.extend((path.len() as u16).to_le_bytes());
            out.extend(0_u16.to_le_bytes());
        };
        bytes.extend(b"PK\x03\x04");
        fields(&mut bytes);
        bytes.extend(path.as_bytes());
        bytes.extend(content);
        directory.extend(b"PK\x01\x02");
        directory.extend(VERSION.to_le_bytes());
        fields(&mut directory);
        // comment, disk, internal attributes, external attributes
        directory.extend([0; 10]);
        directory.extend(at.to_le_bytes());
        directory.extend(path.as_bytes());
    }
    let (at, count) = (bytes.len() as u32, entries.len() as u16);
    bytes.extend(&directory);
    bytes.extend(b"PK\x05\x06\0\0\0\0");
    bytes.extend(count.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend((directory.len() as u32).to_le_bytes());
    bytes.extend(at.to_le_bytes());
    bytes.extend([0; 2]);
    bytes
}
