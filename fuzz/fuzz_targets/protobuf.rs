//! Any bytes as a protobuf payload of a message with every kind of field.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../one_message.rs"]
mod one_message;
#[path = "../one_thread.rs"]
mod one_thread;

fuzz_target!(init: one_thread::init(), |data: &[u8]| {
    let Some((choice, payload)) = data.split_first() else { return };
    let fields = match choice % 3 {
        0 => [".packed[2]", ".inner.inner.value", ".items{id==3}.value"],
        1 => [".packed[-1]", ".value", ".items[-1].value"],
        _ => [".zigzag", ".fixed", r#".items{name=="x"}.packed[0]"#],
    };
    one_message::read("protobuf", Some(("f.M", "protobuf", include_bytes!("../message.binpb"))), payload, fields);
});
