//! Any bytes as a schema, in each schema language.
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
    one_message::read(message, Some(("a/msg/M", encoding, schema)), &[0, 1, 0, 0, 7, 7, 7, 7, 7, 7, 7, 7], [".x", ".y[0]", ".z.w"]);
});
