//! Any bytes as a CDR or ROS 1 payload of a schema with every kind of field.
#![no_main]

use libfuzzer_sys::fuzz_target;

#[path = "../one_message.rs"]
mod one_message;
#[path = "../one_thread.rs"]
mod one_thread;

const SCHEMA: &str = "\
std_msgs/Header header
string[] name
float64[] position
wstring wide
a/Item[] items
a/Item[2] pair
a/Empty[3] nothing
bool[5] flags
string<=8[<=4] words
uint64 large
int8 small
float32[3] last
===
MSG: a/Item
int16 id
string text
float64[] values
===
MSG: a/Empty
===
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
===
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
";

fuzz_target!(init: one_thread::init(), |data: &[u8]| {
    let Some((choice, payload)) = data.split_first() else { return };
    let fields = match choice % 4 {
        0 => [r#".position{name=="a"}"#, ".last[-1]", ".large"],
        1 => [".items{id==3}.values[1]", ".pair[1].id", ".words[0]"],
        2 => [".items[-1].values[-1]", r#"{small==1}.large"#, ".flags[4]"],
        _ => [r#".position{name!="a"}"#, r#".items{text=="x"}.id"#, ".small"],
    };
    if choice & 4 == 0 {
        one_message::read("cdr", Some(("a/M", "ros2msg", SCHEMA.as_bytes())), payload, fields);
    } else {
        let schema = SCHEMA.replace("wstring", "string");
        one_message::read("ros1", Some(("a/M", "ros1msg", schema.as_bytes())), payload, fields);
    }
});
