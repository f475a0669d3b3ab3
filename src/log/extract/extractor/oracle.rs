//! Plans against dynamic decoders that other people wrote: the same payload must give the same values.
#![allow(clippy::unwrap_used)]

use crate::log::extract::extractor::Extractor;
use crate::log::extract::extractor::taken::Taken;
use crate::log::file::structure::Schema;
use crate::log::path::MessagePath;
use crate::log::schema::Layout;
use crate::log::value::Raw;
use proptest::prelude::*;
use prost_reflect::{DescriptorPool, DynamicMessage, Value as Protobuf};
use re_cdr::{BigEndian, CdrEndian, CdrReader, CdrWriter, LittleEndian};
use re_ros_msg::deserialize::{MapResolver, Value as Ros, decode_message, primitive_array::PrimitiveArray};

const ROS_SCHEMA: &str = "\
uint8 KIND_A=1
a/Stamp stamp
string frame
bool on
int8 tiny
string[] name
float64[] velocity
a/Item[] items
a/Item[2] pair
uint16[3] fixed
float32 single
uint64 large 7
int16[<=9] short
float64 last
===
MSG: a/Item
uint8 id
string text
float64 value
===
MSG: a/Stamp
int32 sec
uint32 nanosec
";

/// What a message of that schema holds.
#[derive(Debug, Clone)]
struct Content {
    sec: i32,
    frame: String,
    on: bool,
    tiny: i8,
    joints: Vec<(String, f64)>,
    items: Vec<(u8, String, f64)>,
    fixed: [u16; 3],
    single: f32,
    large: u64,
    short: Vec<i16>,
    last: f64,
}

prop_compose! {
    fn content()(
        sec: i32, frame in "[a-z]{0,9}", on: bool, tiny: i8,
        joints in prop::collection::vec(("[ab]{0,3}", -1e6..1e6_f64), 0..5),
        items in prop::collection::vec((0..4_u8, "[a-z]{0,5}", -1e6..1e6_f64), 2..6),
        fixed: [u16; 3], single in -1e6..1e6_f32, large: u64,
        short in prop::collection::vec(any::<i16>(), 0..9), last in -1e6..1e6_f64,
    ) -> Content {
        Content { sec, frame, on, tiny, joints, items, fixed, single, large, short, last }
    }
}

impl Content {
    fn cdr<BO: CdrEndian>(&self) -> Vec<u8> {
        let mut body = Vec::new();
        let mut w = CdrWriter::<BO>::new(&mut body);
        w.write_i32(self.sec);
        w.write_u32(5);
        w.write_string(&self.frame);
        w.write_bool(self.on);
        w.write_i8(self.tiny);
        w.write_sequence_length(self.joints.len());
        self.joints.iter().for_each(|(name, _)| w.write_string(name));
        w.write_sequence_length(self.joints.len());
        self.joints.iter().for_each(|(_, velocity)| w.write_f64(*velocity));
        w.write_sequence_length(self.items.len());
        for (id, text, value) in self.items.iter().chain(&self.items[..2]) {
            w.write_u8(*id);
            w.write_string(text);
            w.write_f64(*value);
        }
        self.fixed.iter().for_each(|value| w.write_u16(*value));
        w.write_f32(self.single);
        w.write_u64(self.large);
        w.write_sequence_length(self.short.len());
        self.short.iter().for_each(|value| w.write_i16(*value));
        w.write_f64(self.last);
        body
    }
}

/// What a value is as a number.
fn ros_number(value: &Ros) -> f64 {
    match value {
        Ros::Bool(v) => f64::from(u8::from(*v)),
        Ros::I8(v) => f64::from(*v),
        Ros::U8(v) => f64::from(*v),
        Ros::I32(v) => f64::from(*v),
        Ros::U64(v) => *v as f64,
        Ros::F32(v) => f64::from(*v),
        Ros::F64(v) => *v,
        other => panic!("{other:?}"),
    }
}

fn field<'v>(value: &'v Ros, name: &str) -> &'v Ros {
    let Ros::Message(fields) = value else { panic!("{value:?}") };
    &fields[name]
}

fn take((plan, paths): &(Extractor, usize), payload: &[u8]) -> Vec<Option<f64>> {
    let mut taken = Taken::default();
    plan.decode(payload, &mut taken).unwrap();
    let number = |raw: &Raw<'_>| match raw {
        Raw::Missing => None,
        Raw::Number(value) => Some(*value),
        Raw::Integer(value) => Some(*value as f64),
        Raw::Text(text) => Some(text.len() as f64),
    };
    (0..*paths).map(|slot| number(taken.get(slot))).collect()
}

fn plan(encoding: &str, schema: Option<&Schema>, paths: &[&str]) -> (Extractor, usize) {
    let paths: Vec<MessagePath> = paths.iter().map(|path| format!("/t{path}").parse().unwrap()).collect();
    let plan = Extractor::compile(&Layout::parse(encoding, schema).unwrap(), &paths.iter().collect::<Vec<_>>()).unwrap();
    (plan, paths.len())
}

fn ros_paths() -> [&'static str; 12] {
    [
        ".stamp.sec",
        ".on",
        ".tiny",
        r#".velocity{name=="a"}"#,
        ".items[-1].value",
        ".pair[1].id",
        ".fixed[2]",
        ".single",
        ".large",
        ".short[0]",
        ".last",
        ".items{id==2}.value",
    ]
}

fn expected(message: &Ros) -> Vec<Option<f64>> {
    let list = |name| match field(message, name) {
        Ros::Sequence(values) | Ros::Array(values) => values,
        other => panic!("{other:?}"),
    };
    let Ros::PrimitiveSeq(PrimitiveArray::String(names)) = field(message, "name") else { panic!() };
    let Ros::PrimitiveSeq(PrimitiveArray::F64(velocity)) = field(message, "velocity") else { panic!() };
    let Ros::PrimitiveArray(PrimitiveArray::U16(fixed)) = field(message, "fixed") else { panic!() };
    let Ros::PrimitiveSeq(PrimitiveArray::I16(short)) = field(message, "short") else { panic!() };
    let number = |name| Some(ros_number(field(message, name)));
    vec![
        Some(ros_number(field(field(message, "stamp"), "sec"))),
        number("on"),
        number("tiny"),
        names.iter().position(|name| name == "a").map(|index| velocity[index]),
        list("items").last().map(|item| ros_number(field(item, "value"))),
        Some(ros_number(field(&list("pair")[1], "id"))),
        Some(f64::from(fixed[2])),
        number("single"),
        number("large"),
        short.first().map(|value| f64::from(*value)),
        number("last"),
        list("items").iter().find(|item| ros_number(field(item, "id")) == 2.0).map(|item| ros_number(field(item, "value"))),
    ]
}

fn dynamic<BO: CdrEndian>(body: &[u8]) -> Ros {
    let schema = re_ros_msg::MessageSchema::parse("a/M", ROS_SCHEMA).unwrap();
    let resolver = MapResolver::new(schema.dependencies.iter().map(|spec| (spec.name.clone(), spec)));
    decode_message(&mut CdrReader::<BO>::new(body), &schema.spec, &resolver).unwrap()
}

fn ros_schema(encoding: &str, text: &str) -> Schema {
    Schema { name: "a/M".into(), encoding: encoding.into(), data: text.as_bytes().to_vec() }
}

proptest! {
    #[test]
    fn cdr_plans_agree_with_the_dynamic_decoder_in_both_byte_orders(content in content()) {
        let plan = plan("cdr", Some(&ros_schema("ros2msg", ROS_SCHEMA)), &ros_paths());
        let (little, big) = (content.cdr::<LittleEndian>(), content.cdr::<BigEndian>());
        prop_assert_eq!(take(&plan, &[&[0, 1, 0, 0], &little[..]].concat()), expected(&dynamic::<LittleEndian>(&little)));
        prop_assert_eq!(take(&plan, &[&[0, 0, 0, 0], &big[..]].concat()), expected(&dynamic::<BigEndian>(&big)));
    }

    #[test]
    fn messages_that_follow_each_other_are_read_as_each_alone(
        first in content(), changes in prop::collection::vec((0..8_u8, -1e6..1e6_f64), 1..12), filters: bool,
    ) {
        let few = ros_paths().into_iter().filter(|path| filters || !path.contains("{id")).collect::<Vec<_>>();
        let (plan, paths) = plan("cdr", Some(&ros_schema("ros2msg", ROS_SCHEMA)), &[&few[..], &[".frame", ".items[0].text"]].concat());
        let mut content = first;
        let mut payloads = Vec::new();
        for (change, value) in changes {
            match change {
                0 => content.joints.reverse(),
                1 => content.frame.push('x'),
                2 => content.frame = content.frame.chars().map(|_| 'y').collect(),
                3 => content.items[0].1.push('z'),
                _ => {
                    content.sec = value as i32;
                    content.joints.iter_mut().for_each(|(_, velocity)| *velocity += value);
                    content.items.iter_mut().for_each(|(_, _, number)| *number -= value);
                    content.fixed[2] = value as u16;
                    content.last = value;
                }
            }
            payloads.push(match change {
                7 => [&[0, 0, 0, 0], &content.cdr::<BigEndian>()[..]].concat(),
                6 => vec![0, 1, 0, 0, 9],
                _ => [&[0, 1, 0, 0], &content.cdr::<LittleEndian>()[..]].concat(),
            });
        }
        let mut together = Taken::default();
        for payload in &payloads {
            let mut alone = Taken::default();
            prop_assert_eq!(plan.decode(payload, &mut together), plan.decode(payload, &mut alone));
            for slot in 0..paths {
                prop_assert!(payload.len() < 9 || together.get(slot) == alone.get(slot), "{:?} {:?}", together.get(slot), alone.get(slot));
            }
        }
    }

    #[test]
    fn a_cut_payload_is_broken_and_never_a_panic(content in content(), cut in 0.0..1.0_f64) {
        let (plan, _) = plan("cdr", Some(&ros_schema("ros2msg", ROS_SCHEMA)), &ros_paths());
        let whole = [&[0, 1, 0, 0], &content.cdr::<LittleEndian>()[..]].concat();
        let mut taken = Taken::default();
        prop_assert!(plan.decode(&whole[..(whole.len() as f64 * cut) as usize], &mut taken).is_none());
    }

    #[test]
    fn protobuf_plans_agree_with_the_dynamic_decoder(
        value in -1e6..1e6_f64, zigzag: i64, fixed: i32, packed in prop::collection::vec(any::<i32>(), 0..6),
        ids in prop::collection::vec(0..4_u32, 0..5), inner: bool,
    ) {
        let data = include_bytes!("../../../../fuzz/message.binpb").to_vec();
        let message = DescriptorPool::decode(&data[..]).unwrap().get_message_by_name("f.M").unwrap();
        let mut dynamic = DynamicMessage::new(message.clone());
        dynamic.set_field_by_name("value", Protobuf::F64(value));
        dynamic.set_field_by_name("zigzag", Protobuf::I64(zigzag));
        dynamic.set_field_by_name("fixed", Protobuf::I32(fixed));
        dynamic.set_field_by_name("packed", Protobuf::List(packed.iter().copied().map(Protobuf::I32).collect()));
        let item = |id: u32| {
            let mut item = DynamicMessage::new(message.clone());
            item.set_field_by_name("id", Protobuf::U32(id));
            item.set_field_by_name("value", Protobuf::F64(f64::from(id) + 0.5));
            Protobuf::Message(item)
        };
        dynamic.set_field_by_name("items", Protobuf::List(ids.iter().copied().map(item).collect()));
        if inner {
            dynamic.set_field_by_name("inner", item(9));
        }
        let schema = Schema { name: "f.M".into(), encoding: "protobuf".into(), data };
        let paths = [".value", ".zigzag", ".fixed", ".packed[1]", ".packed[-1]", ".items{id==2}.value", ".items[-1].id", ".inner.value", ".flag"];
        let payload = prost_reflect::prost::Message::encode_to_vec(&dynamic);
        let expected = vec![
            Some(value), Some(zigzag as f64), Some(f64::from(fixed)),
            packed.get(1).map(|v| f64::from(*v)), packed.last().map(|v| f64::from(*v)),
            ids.contains(&2).then_some(2.5), ids.last().map(|id| f64::from(*id)), inner.then_some(9.5), Some(0.0),
        ];
        prop_assert_eq!(take(&plan("protobuf", Some(&schema), &paths), &payload), expected);
    }

    #[test]
    fn json_plans_agree_with_the_dynamic_decoder(
        values in prop::collection::vec(-1e6..1e6_f64, 0..5), ids in prop::collection::vec(0..4_i64, 0..5), on: bool, names_last: bool,
    ) {
        let names: Vec<String> = (0..values.len()).map(|index| format!("joint {index}")).collect();
        let items: Vec<_> = ids.iter().map(|id| serde_json::json!({"id": id, "deep": {"v": [id, id + 1]}})).collect();
        let mut value = serde_json::json!({"on": on, "x": {"text": "4.5", "other": [1, [2, {}], null]}, "items": items});
        let fields = value.as_object_mut().unwrap();
        let mut arrays = [("name", serde_json::json!(names)), ("velocity", serde_json::json!(values))];
        if names_last {
            arrays.reverse(); // the array of names comes after the one that it picks from
        }
        for (name, array) in arrays {
            fields.insert(name.into(), array);
        }
        let paths = [r#".velocity{name=="joint 2"}"#, ".on", ".items{id==2}.deep.v[1]", ".items[-1].id", ".velocity[0]", ".gone.field", "{on==true}.items[0].id"];
        let number = |value: Option<&serde_json::Value>| value.and_then(serde_json::Value::as_f64);
        let expected = vec![
            number(value["velocity"].get(2)), Some(f64::from(u8::from(on))),
            ids.contains(&2).then_some(3.0), ids.last().map(|id| *id as f64), number(value["velocity"].get(0)), None,
            number(value["items"].get(0).map(|item| &item["id"])).filter(|_| on),
        ];
        prop_assert_eq!(take(&plan("json", None, &paths), value.to_string().as_bytes()), expected);
    }
}

#[test]
fn ros1_payloads_have_no_alignment_and_texts_no_zero() {
    let text = "Header header\nuint8 KIND=3\nstring label\ntime when\nfloat64 value\nduration span\n===\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";
    let mut payload = Vec::new();
    for word in [1_u32, 50, 60, 3] {
        payload.extend(word.to_le_bytes());
    }
    payload.extend(b"map");
    payload.extend(5_u32.to_le_bytes());
    payload.extend(b"hello");
    payload.extend(70_u32.to_le_bytes());
    payload.extend(80_u32.to_le_bytes());
    payload.extend(2.5_f64.to_le_bytes());
    payload.extend((-3_i32).to_le_bytes());
    payload.extend(4_i32.to_le_bytes());
    let paths = [".header.stamp.sec", ".header.stamp.nsec", ".label", ".when.sec", ".value", ".span.sec"];
    let taken = take(&plan("ros1", Some(&ros_schema("ros1msg", text)), &paths), &payload);
    assert_eq!(taken, [50.0, 60.0, 5.0, 70.0, 2.5, -3.0].map(Some));
}

#[test]
fn idl_and_msg_give_the_same_plan() {
    let idl = "module a { struct Item { octet id; string text; double value; }; struct Stamp { long sec; unsigned long nanosec; };
        typedef unsigned short three[3];
        struct M { a::Stamp stamp; string frame; boolean on; int8 tiny; sequence<string> name; sequence<double> velocity;
        sequence<a::Item> items; Item pair[2]; three fixed; float single; @default (value=7) uint64 large; sequence<short, 9> short_; double last; }; };";
    let paths = [".stamp.sec", r#".velocity{name=="a"}"#, ".pair[1].id", ".fixed[2]", ".large", ".last"];
    let content = Content {
        sec: 3,
        frame: "odd".into(),
        on: true,
        tiny: -1,
        joints: vec![("b".into(), 1.0), ("a".into(), 2.0)],
        items: vec![(1, "x".into(), 4.0), (2, String::new(), 5.0)],
        fixed: [6, 7, 8],
        single: 9.0,
        large: 10,
        short: vec![11],
        last: 12.0,
    };
    let payload = [&[0, 1, 0, 0], &content.cdr::<LittleEndian>()[..]].concat();
    let taken = take(&plan("cdr", Some(&ros_schema("ros2idl", idl)), &paths), &payload);
    assert_eq!(taken, [3.0, 2.0, 2.0, 8.0, 10.0, 12.0].map(Some));
}

#[test]
fn a_wide_text_before_the_field_is_skipped() {
    let mut payload = vec![0, 1, 0, 0];
    payload.extend(2_u32.to_le_bytes());
    payload.extend([65, 0, 0, 0, 66, 0, 0, 0]);
    payload.extend(7_i32.to_le_bytes());
    let taken = take(&plan("cdr", Some(&ros_schema("ros2msg", "wstring wide\nint32 x\n")), &[".x"]), &payload);
    assert_eq!(taken, [Some(7.0)]);
}

#[test]
fn a_path_that_leads_nowhere_says_what_there_is() {
    let layout = Layout::parse("cdr", Some(&ros_schema("ros2msg", ROS_SCHEMA))).unwrap();
    let wrong = |path: &str| {
        let path: MessagePath = format!("/t{path}").parse().unwrap();
        Extractor::compile(&layout, &[&path]).unwrap_err().1.to_string()
    };
    assert!(wrong(".lst").contains("last"));
    assert!(wrong(".velocity").contains("velocity[0]"));
    assert!(wrong(".stamp").contains("nanosec"));
    assert!(wrong(".last[0]").contains("not an array"));
    assert!(wrong(".items.value").contains("items[0]"));
    assert!(wrong(".last.x").contains("\"x\""));
}
