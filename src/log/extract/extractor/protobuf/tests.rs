//! Fields of every kind, described by hand, against the dynamic decoder.
#![allow(clippy::unwrap_used)]

use crate::log::extract::extractor::Extractor;
use crate::log::extract::extractor::taken::Taken;
use crate::log::file::structure::Schema;
use crate::log::path::MessagePath;
use crate::log::schema::Layout;
use crate::log::schema_error::SchemaError;
use crate::log::value::Raw;
use prost::Message as _;
use prost_reflect::{DescriptorPool, DynamicMessage, MapKey, Value};
use prost_types::field_descriptor_proto::{Label, Type};
use prost_types::{
    DescriptorProto, EnumDescriptorProto, EnumValueDescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet,
    MessageOptions, OneofDescriptorProto,
};

fn field(name: &str, number: i32, kind: Type) -> FieldDescriptorProto {
    let mut field = FieldDescriptorProto { name: Some(name.into()), number: Some(number), ..FieldDescriptorProto::default() };
    field.set_label(Label::Optional);
    field.set_type(kind);
    field
}

fn of_type(name: &str, number: i32, kind: Type, type_name: &str) -> FieldDescriptorProto {
    FieldDescriptorProto { type_name: Some(type_name.into()), ..field(name, number, kind) }
}

fn list(mut field: FieldDescriptorProto) -> FieldDescriptorProto {
    field.set_label(Label::Repeated);
    field
}

fn message(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto { name: Some(name.into()), field, ..DescriptorProto::default() }
}

/// The schema of message `M` in package `p`.
fn schema(message: DescriptorProto, syntax: &str) -> Schema {
    let gears = ["PARK", "DRIVE", "REVERSE"].iter().zip([0, 4, -1]);
    let value = gears.map(|(name, number)| EnumValueDescriptorProto {
        name: Some((*name).into()),
        number: Some(number),
        ..EnumValueDescriptorProto::default()
    });
    let file = FileDescriptorProto {
        name: Some("m.proto".into()),
        package: Some("p".into()),
        message_type: vec![message],
        enum_type: vec![EnumDescriptorProto { name: Some("Gear".into()), value: value.collect(), ..EnumDescriptorProto::default() }],
        syntax: Some(syntax.into()),
        ..FileDescriptorProto::default()
    };
    Schema { name: "p.M".into(), encoding: "protobuf".into(), data: FileDescriptorSet { file: vec![file] }.encode_to_vec() }
}

fn layout(schema: &Schema) -> Result<Layout, SchemaError> {
    Layout::parse("protobuf", Some(schema))
}

fn take(schema: &Schema, paths: &[&str], payload: &[u8]) -> Vec<Option<f64>> {
    let paths: Vec<MessagePath> = paths.iter().map(|path| format!("/t{path}").parse().unwrap()).collect();
    let plan = Extractor::compile(&layout(schema).unwrap(), &paths.iter().collect::<Vec<_>>()).unwrap();
    let mut taken = Taken::default();
    plan.decode(payload, &mut taken).unwrap();
    let number = |slot| match taken.get(slot) {
        Raw::Number(value) => Some(*value),
        Raw::Integer(value) => Some(*value as f64),
        Raw::Text(_) | Raw::Missing => None,
    };
    (0..paths.len()).map(number).collect()
}

fn dynamic(schema: &Schema) -> DynamicMessage {
    DynamicMessage::new(DescriptorPool::decode(&schema.data[..]).unwrap().get_message_by_name("p.M").unwrap())
}

#[test]
fn members_of_a_oneof_are_missing_unless_set_and_groups_are_passed_over() {
    let member = |name, number| FieldDescriptorProto { oneof_index: Some(0), ..field(name, number, Type::Double) };
    let mut setpoint = message("M", vec![member("torque_nm", 2), member("speed_mps", 3), field("plain", 4, Type::Double)]);
    setpoint.oneof_decl = vec![OneofDescriptorProto { name: Some("setpoint".into()), ..OneofDescriptorProto::default() }];
    // group 5 holds a field 2, which is not the message's
    let payload = [&[0x2b, 0x11][..], &1.0_f64.to_le_bytes(), &[0x2c, 0x19], &2.0_f64.to_le_bytes()].concat();
    let taken = take(&schema(setpoint, "proto3"), &[".torque_nm", ".speed_mps", ".plain"], &payload);
    assert_eq!(taken, [None, Some(2.0), Some(0.0)]);
}

#[test]
fn a_value_of_a_map_is_found_by_its_key() {
    let mut whole = message("M", vec![list(of_type("wheels", 1, Type::Message, ".p.M.WheelsEntry"))]);
    let mut entry = message("WheelsEntry", vec![field("key", 1, Type::String), field("value", 2, Type::Double)]);
    entry.options = Some(MessageOptions { map_entry: Some(true), ..MessageOptions::default() });
    whole.nested_type = vec![entry];
    let schema = schema(whole, "proto3");
    let mut message = dynamic(&schema);
    let wheels = [("front", 1.5), ("left", 2.5), ("right", 0.0)];
    let map = wheels.iter().map(|(name, speed)| (MapKey::String((*name).into()), Value::F64(*speed))).collect();
    message.set_field_by_name("wheels", Value::Map(map));
    let paths = [r#".wheels{key=="left"}.value"#, r#".wheels{key=="right"}.value"#, r#".wheels{key=="rear"}.value"#];
    assert_eq!(take(&schema, &paths, &message.encode_to_vec()), [Some(2.5), Some(0.0), None]);
}

#[test]
fn enumerations_are_numbers_whose_names_the_schema_tells() {
    let whole = message("M", vec![of_type("gear", 1, Type::Enum, "Gear"), list(of_type("gears", 2, Type::Enum, ".p.Gear"))]);
    let schema = schema(whole, "proto3");
    let mut message = dynamic(&schema);
    assert_eq!(take(&schema, &[".gear", ".gears[0]"], &message.encode_to_vec()), [Some(0.0), None]);
    message.set_field_by_name("gear", Value::EnumNumber(-1));
    message.set_field_by_name("gears", Value::List([4, -1].map(Value::EnumNumber).into()));
    assert_eq!(take(&schema, &[".gear", ".gears[0]", ".gears[-1]"], &message.encode_to_vec()), [-1.0, 4.0, -1.0].map(Some));
    let leaves = layout(&schema).unwrap().leaves();
    assert_eq!(*leaves[0].names, [("PARK".to_owned(), 0), ("DRIVE".to_owned(), 4), ("REVERSE".to_owned(), -1)]);
}

#[test]
fn repeated_numbers_are_read_packed_and_not() {
    let schema = schema(message("M", vec![list(field("v", 1, Type::Sint32)), list(field("w", 2, Type::Float))]), "proto3");
    let packed = [&[0x0a, 3, 1, 2, 3][..], &[0x12, 8], &1.5_f32.to_le_bytes(), &2.5_f32.to_le_bytes()].concat();
    let single = [&[0x08, 1, 0x08, 2, 0x08, 3, 0x15][..], &1.5_f32.to_le_bytes(), &[0x15], &2.5_f32.to_le_bytes()].concat();
    for payload in [packed, single] {
        assert_eq!(take(&schema, &[".v[0]", ".v[2]", ".w[-1]"], &payload), [Some(-1.0), Some(-2.0), Some(2.5)]);
    }
}

#[test]
fn fields_of_proto2_are_missing_or_have_the_default_that_they_declare() {
    let declared = |name, number, kind, text: &str| FieldDescriptorProto { default_value: Some(text.into()), ..field(name, number, kind) };
    let gear = FieldDescriptorProto { type_name: Some(".p.Gear".into()), ..declared("gear", 4, Type::Enum, "DRIVE") };
    let fields = vec![field("a", 1, Type::Double), declared("b", 2, Type::Int64, "-7"), declared("c", 3, Type::Bool, "true"), gear];
    let schema = schema(message("M", fields), "proto2");
    let paths = [".a", ".b", ".c", ".gear"];
    assert_eq!(take(&schema, &paths, &[]), [None, Some(-7.0), Some(1.0), Some(4.0)]);
    let mut message = dynamic(&schema);
    message.set_field_by_name("b", Value::I64(i64::MIN));
    message.set_field_by_name("gear", Value::EnumNumber(0));
    assert_eq!(take(&schema, &paths, &message.encode_to_vec()), [None, Some(i64::MIN as f64), Some(1.0), Some(0.0)]);
}

#[test]
fn fields_are_found_by_the_names_that_json_spells() {
    let schema = schema(message("M", vec![field("wheel_speed_mps", 1, Type::Int32)]), "proto3");
    assert_eq!(take(&schema, &[".wheelSpeedMps", ".wheel_speed_mps"], &[0x08, 5]), [Some(5.0), Some(5.0)]);
}

#[test]
fn a_type_name_that_leads_nowhere_is_an_error() {
    // names that no writer makes, from which a decoder of descriptors could look for a place in the source
    for name in [".).M", "", ".", "p..M", ".p.Gone", "Gone"] {
        for syntax in ["proto3", "proto1", ""] {
            let whole = message("M", vec![field("value", 1, Type::Double), of_type("inner", 5, Type::Message, name)]);
            assert!(matches!(layout(&schema(whole, syntax)), Err(SchemaError::Broken { .. })), "{name:?}");
        }
    }
    let impossible = message("M", vec![field("value", 0, Type::Double)]);
    assert!(matches!(layout(&schema(impossible, "proto3")), Err(SchemaError::Broken { .. })));
}
