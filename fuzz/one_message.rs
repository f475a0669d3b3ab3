//! A log that holds one message, read with a signal map: the way to a decoder.

use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use pivot_cal::log::{SignalMap, Source, VehicleOverrides, read_bytes};
use std::collections::BTreeMap;
use std::io::Cursor;

/// Reads `payload`, of the given encoding and schema, with the paths `fields` for the three signals that every log needs.
pub fn read(encoding: &str, schema: Option<(&str, &str, &[u8])>, payload: &[u8], fields: [&str; 3]) {
    let options = WriteOptions::new().compression(None).use_chunks(false);
    let Ok(mut writer) = Writer::with_options(Cursor::new(Vec::new()), options) else { return };
    let id = schema.map_or(Ok(0), |(name, encoding, data)| writer.add_schema(name, encoding, data));
    let Ok(channel) = id.and_then(|id| writer.add_channel(id, "/t", encoding, &BTreeMap::new())) else { return };
    let header = MessageHeader { channel_id: channel, sequence: 0, log_time: 1, publish_time: 1 };
    if writer.write_to_known_channel(&header, payload).is_err() || writer.finish().is_err() {
        return;
    }
    let [speed, torque, angle] = fields;
    let map = format!(
        "[vehicle]\nwheelbase_m = 1\nwheel_radius_m = 0.1\n[signals]\nspeed = {{ path = '/t{speed}' }}\ntorque = {{ path = '/t{torque}' }}\nangle = {{ path = '/t{angle}' }}\n"
    );
    let map = SignalMap::from_toml(&map).expect("the paths are written in the target");
    let bytes = writer.into_inner().into_inner();
    let _ = read_bytes(bytes, "fuzz", &Source::Map(map), &VehicleOverrides::default());
}
