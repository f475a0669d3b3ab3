//! Any bytes as a JSON payload.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../one_message.rs"]
mod one_message;
#[path = "../one_thread.rs"]
mod one_thread;

fuzz_target!(init: one_thread::init(), |data: &[u8]| {
    let Some((choice, payload)) = data.split_first() else { return };
    let fields = match choice % 3 {
        0 => [r#".v{name=="a"}"#, ".list[-1]", ".x"],
        1 => [".items{id==3}.v[1]", "{on==true}.x", ".list[2]"],
        _ => [".a.b.c", ".items[0].id", ".list[1]"],
    };
    if choice & 0x80 == 0 {
        one_message::read("json", None, payload, fields);
    } else {
        one_message::look("json", None, payload);
    }
});
