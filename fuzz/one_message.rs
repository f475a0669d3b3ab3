//! A log that holds one message, read with a signal map or looked through: the way to a decoder.

use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use pivot_cal::internals::survey_bytes;
use pivot_cal::log::{Depth, SignalMap, Source, VehicleOverrides, read_bytes};
use std::collections::BTreeMap;
use std::io::Cursor;

/// Reads `payload`, of the given encoding and schema, with the paths `fields` for the three signals that every log needs.
pub fn read(encoding: &str, schema: Option<(&str, &str, &[u8])>, payload: &[u8], fields: [&str; 3]) {
    let Some(bytes) = log(encoding, schema, payload) else { return };
    let [speed, torque, angle] = fields;
    let map = format!(
        "[vehicle]\nwheelbase_m = 1\nwheel_radius_m = 0.1\n[signals]\nspeed = {{ path = '/t{speed}' }}\ntorque = {{ path = '/t{torque}' }}\nangle = {{ path = '/t{angle}' }}\n"
    );
    let map = SignalMap::from_toml(&map).expect("the paths are written in the target");
    let _ = read_bytes(bytes, "fuzz", &Source::Map(map), &VehicleOverrides::default());
}

/// Looks for signals in `payload`, of the given encoding and schema: every value of the message is listed and read.
#[allow(dead_code)] // not every target does
pub fn look(encoding: &str, schema: Option<(&str, &str, &[u8])>, payload: &[u8]) {
    let Some(bytes) = log(encoding, schema, payload) else { return };
    let _ = survey_bytes(bytes, "fuzz", &Source::Detect, Depth::Everything);
}

fn log(encoding: &str, schema: Option<(&str, &str, &[u8])>, payload: &[u8]) -> Option<Vec<u8>> {
    let options = WriteOptions::new().compression(None).use_chunks(false);
    let mut writer = Writer::with_options(Cursor::new(Vec::new()), options).ok()?;
    let id = schema.map_or(Ok(0), |(name, encoding, data)| writer.add_schema(name, encoding, data)).ok()?;
    let channel = writer.add_channel(id, "/t", encoding, &BTreeMap::new()).ok()?;
    let header = MessageHeader { channel_id: channel, sequence: 0, log_time: 1, publish_time: 1 };
    writer.write_to_known_channel(&header, payload).ok()?;
    writer.finish().ok()?;
    Some(writer.into_inner().into_inner())
}
