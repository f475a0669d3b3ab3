//! Slices: which elements of an array they pick.

use crate::log::extract::extractor::request_tree::Pick;
use std::ops::Range;

/// The elements from `first` to `last`, both included and negative from the end, that an array of `count` has.
pub(crate) fn elements(first: i64, last: i64, count: usize) -> Range<usize> {
    let count = i64::try_from(count).unwrap_or(i64::MAX);
    let from_start = |index: i64| if index < 0 { index.saturating_add(count) } else { index };
    let start = from_start(first).clamp(0, count);
    let end = from_start(last).saturating_add(1).clamp(start, count);
    start as usize..end as usize
}

impl Pick {
    /// Whether the array must be counted before it is known which elements are meant.
    pub(crate) fn counts_from_the_end(&self) -> bool {
        match self {
            Self::Index(index) => *index < 0,
            // −1 is the end, however far it is
            Self::Each { first, last, .. } => *first < 0 || *last < -1,
            Self::First { .. } | Self::Find { .. } | Self::At { .. } => false,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::log::extract::extractor::Extractor;
    use crate::log::extract::extractor::taken::Taken;
    use crate::log::extractor_error::PlanError;
    use crate::log::file::structure::Schema;
    use crate::log::path::MessagePath;
    use crate::log::schema::Layout;
    use prost::Message as _;
    use prost_types::field_descriptor_proto::{Label, Type};
    use prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};
    use re_cdr::{CdrWriter, LittleEndian};

    #[test]
    fn both_ends_are_included_and_what_the_array_does_not_have_is_left_out() {
        let of = |first, last| elements(first, last, 5).collect::<Vec<_>>();
        assert_eq!(of(0, -1), [0, 1, 2, 3, 4]);
        assert_eq!(of(1, 2), [1, 2]);
        assert_eq!(of(-2, -1), [3, 4]);
        assert_eq!(of(-9, 1), [0, 1]);
        assert_eq!(of(3, 99), [3, 4]);
        assert!([(4, 2), (7, 9), (0, -6)].iter().all(|(first, last)| of(*first, *last).is_empty()));
        assert_eq!(elements(0, -1, 0), 0..0);
        assert_eq!(elements(i64::MIN, i64::MAX, 3), 0..3);
    }

    const POINTS: [[f64; 2]; 4] = [[0.0, 1.5], [1.0, 0.0], [2.5, -1.0], [-3.0, 7.0]];

    fn ros() -> (Layout, Vec<u8>) {
        let text = "string frame\na/Pose[] poses\nfloat32[] widths\n===\nMSG: a/Pose\nstring id\na/Point at\n===\nMSG: a/Point\nfloat64 x\nfloat64 y\n";
        let schema = Schema { name: "a/Path".into(), encoding: "ros2msg".into(), data: text.into() };
        let mut body = Vec::new();
        let mut w = CdrWriter::<LittleEndian>::new(&mut body);
        w.write_string("map");
        w.write_sequence_length(POINTS.len());
        for (k, [x, y]) in POINTS.iter().enumerate() {
            // texts of several lengths: no two elements are alike
            w.write_string(&"abcd"[..k]);
            w.write_f64(*x);
            w.write_f64(*y);
        }
        w.write_sequence_length(POINTS.len());
        for [_, y] in POINTS {
            w.write_f32(y as f32);
        }
        (Layout::parse("cdr", Some(&schema)).unwrap(), [&[0, 1, 0, 0], &body[..]].concat())
    }

    fn json() -> (Layout, Vec<u8>) {
        let poses: Vec<_> = POINTS.iter().map(|[x, y]| serde_json::json!({ "id": "a", "at": { "y": y, "x": x } })).collect();
        let body = serde_json::json!({ "poses": poses, "widths": POINTS.map(|p| p[1]) }).to_string();
        (Layout::parse("json", None).unwrap(), body.into_bytes())
    }

    fn protobuf() -> (Layout, Vec<u8>) {
        let field = |name: &str, number, label, kind, of: Option<&str>| FieldDescriptorProto {
            name: Some(name.into()),
            number: Some(number),
            label: Some(label as i32),
            r#type: Some(kind as i32),
            type_name: of.map(Into::into),
            ..FieldDescriptorProto::default()
        };
        let message = |name: &str, field: Vec<_>| DescriptorProto { name: Some(name.into()), field, ..DescriptorProto::default() };
        let (one, many) = (Label::Optional, Label::Repeated);
        let file = FileDescriptorProto {
            name: Some("p.proto".into()),
            package: Some("a".into()),
            syntax: Some("proto3".into()),
            message_type: vec![
                message("Path", vec![field("poses", 1, many, Type::Message, Some(".a.Pose")), field("widths", 2, many, Type::Float, None)]),
                message("Pose", vec![field("at", 3, one, Type::Message, Some(".a.Point"))]),
                message("Point", vec![field("x", 1, one, Type::Double, None), field("y", 2, one, Type::Double, None)]),
            ],
            ..FileDescriptorProto::default()
        };
        let schema =
            Schema { name: "a.Path".into(), encoding: "protobuf".into(), data: FileDescriptorSet { file: vec![file] }.encode_to_vec() };
        let mut body = Vec::new();
        for [x, y] in POINTS {
            let mut point = Vec::new();
            // zeros are not written, as proto3 has it
            for (key, value) in [(9, x), (17, y)] {
                if value != 0.0 {
                    point.push(key);
                    point.extend(value.to_le_bytes());
                }
            }
            body.extend([10, point.len() as u8 + 2, 26, point.len() as u8]);
            body.extend(point);
        }
        body.extend([18, 16]);
        for [_, y] in POINTS {
            body.extend((y as f32).to_le_bytes());
        }
        (Layout::parse("protobuf", Some(&schema)).unwrap(), body)
    }

    fn lists(layout: &Layout, payload: &[u8], paths: &[&str]) -> Vec<Vec<f64>> {
        let paths: Vec<MessagePath> = paths.iter().map(|path| format!("/t{path}").parse().unwrap()).collect();
        let plan = Extractor::compile(layout, &paths.iter().collect::<Vec<_>>()).unwrap();
        let mut taken = Taken::default();
        // twice: what one message teaches must not spoil the next
        for _ in 0..2 {
            plan.decode(payload, &mut taken).unwrap();
        }
        (0..paths.len()).map(|slot| taken.list(slot).to_vec()).collect()
    }

    #[test]
    fn every_encoding_gives_the_elements_of_a_slice_in_their_order() {
        let [xs, ys] = [0, 1].map(|k| POINTS.map(|p| p[k]).to_vec());
        let paths = [".poses[:].at.x", ".poses[:].at.y", ".widths[:]", ".poses[1:-2].at.y", ".widths[-2:]"];
        for (layout, payload) in [ros(), json(), protobuf()] {
            let found = lists(&layout, &payload, &paths);
            assert_eq!(found, [xs.clone(), ys.clone(), ys.clone(), ys[1..=2].to_vec(), ys[2..].to_vec()], "{layout:?}");
            // one slice alone: JSON then reads it without building the array
            assert_eq!(lists(&layout, &payload, &[".poses[:].at.x"])[0], xs);
            assert_eq!(lists(&layout, &payload, &[".poses[2:].at.y"])[0], ys[2..]);
        }
        let json = (Layout::parse("json", None).unwrap(), br#"{"poses":[{"at":{"x":1}},{"at":{}},{"at":{"x":"3"}}]}"#);
        let found = lists(&json.0, json.1, &[".poses[:].at.x"]);
        assert!(found[0][0] == 1.0 && found[0][1].is_nan() && found[0][2] == 3.0, "an element without the value keeps its place");
    }

    #[test]
    fn an_empty_array_after_a_full_one_gives_nothing() {
        let (layout, payload) = ros();
        let path: MessagePath = "/t.poses[:].at.x".parse().unwrap();
        let plan = Extractor::compile(&layout, &[&path]).unwrap();
        let empty = [0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let mut taken = Taken::default();
        for (payload, count) in [(&payload[..], 4), (&empty, 0), (&empty, 0), (&payload, 4)] {
            plan.decode(payload, &mut taken).unwrap();
            assert_eq!(taken.list(0).len(), count);
        }
    }

    #[test]
    fn a_slice_within_a_slice_and_a_filter_behind_one_are_refused() {
        let (layout, _) = ros();
        for path in ["/t.poses[:].at[:].x", "/t.poses[:]{id==\"a\"}[:].at.x", "/t.poses[1:2].at{x>1}.y"] {
            let path: MessagePath = path.parse().unwrap();
            let refused = Extractor::compile(&layout, &[&path]).unwrap_err().1;
            assert!(matches!(refused, PlanError::ListWithin | PlanError::NotAnArray { .. }), "{refused}");
        }
    }
}
