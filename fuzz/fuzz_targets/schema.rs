//! Any bytes as a schema, in each schema language: with paths that it may have, or searched for all that it has.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../one_message.rs"]
mod one_message;
#[path = "../one_thread.rs"]
mod one_thread;

fuzz_target!(init: one_thread::init(), |data: &[u8]| {
    let Some((choice, schema)) = data.split_first() else { return };
    let (message, encoding) =
        [("cdr", "ros2msg"), ("cdr", "ros2idl"), ("ros1", "ros1msg"), ("protobuf", "protobuf")][usize::from(choice % 4)];
    let schema = Some(("a/msg/M", encoding, schema));
    let payload = [0, 1, 0, 0, 7, 7, 7, 7, 7, 7, 7, 7];
    if choice & 4 == 0 {
        one_message::read(message, schema, &payload, [".x", ".y[0]", ".z.w"]);
    } else {
        one_message::look(message, schema, &payload);
    }
});
