//! The scanner on trees of a few lines: it sees what is there, and nothing else.

use crate::arrows::{Arrows, arrows};
use crate::floors::objections;
use crate::graph::Graph;
use crate::picture::{Picture, pictures};
use crate::scan::scan;
use crate::tree::{Texts, Tree, tree};

fn texts(files: &[(&str, &str)]) -> Texts {
    files.iter().map(|(path, text)| (format!("src/{path}"), (*text).to_owned())).collect()
}

fn read(files: &[(&str, &str)]) -> (Tree, Arrows) {
    let tree = tree(&texts(files));
    let arrows = arrows(&tree);
    (tree, arrows)
}

/// The ties of these files, as `a.rs > b.rs: Name Name`.
fn ties(files: &[(&str, &str)]) -> Vec<String> {
    let (tree, arrows) = read(files);
    assert!(tree.faults.is_empty(), "{:?}", tree.faults);
    assert!(arrows.faults.is_empty(), "{:?}", arrows.faults);
    let short = |path: &str| path.trim_start_matches("src/").to_owned();
    let described = |names: &std::collections::BTreeSet<String>| names.iter().cloned().collect::<Vec<_>>().join(" ");
    arrows.ties.iter().map(|((from, to), names)| format!("{} > {}: {}", short(from), short(to), described(names))).collect()
}

/// The ties of the module `a` to its sibling `b`, which holds `Thing`, `make` and the module `deep` with `Low`.
fn ties_of_a(text: &str) -> Vec<String> {
    ties(&[
        ("lib.rs", "mod a; mod b;"),
        ("a.rs", text),
        ("b.rs", "pub mod deep; pub struct Thing; pub fn make() -> f64 { 1.0 }"),
        ("b/deep.rs", "pub enum Low { One, Two }"),
    ])
}

#[test]
fn an_import_is_seen() {
    assert_eq!(ties_of_a("use crate::b::Thing;"), ["a.rs > b.rs: Thing"]);
    assert_eq!(ties_of_a("fn f() { use super::b::make; make(); }"), ["a.rs > b.rs: make"]);
    assert_eq!(ties_of_a("use super::b::Thing as _;"), ["a.rs > b.rs: Thing"]);
}

#[test]
fn what_is_no_code_is_not_counted() {
    assert!(ties_of_a("// use crate::b::Thing;\n/* use crate::b::Thing; /* nested */ crate::b::make() */").is_empty());
    assert!(ties_of_a("/// [`crate::b::Thing`]\n//! crate::b::Thing\n/** crate::b::Thing */").is_empty());
    assert!(ties_of_a("const A: &str = \"crate::b::make() \\\" super::b::make()\";").is_empty());
    assert!(ties_of_a("const A: &str = r#\"a \" crate::b::make() \"#; const B: &[u8] = br\"\\\";").is_empty());
    assert!(ties_of_a("pub(in crate::b) struct A; pub(in super::b) use std::fmt;").is_empty());
}

#[test]
fn code_after_literals_is_counted() {
    let before = ["'\"'", "'\\''", "'\\u{1F600}'", "b'\"'", "\"\\\\\"", "r\"\\\"", "r#\"\"\"#", "1.5e-3", "0..2"];
    for literal in before {
        let text = format!("fn f<'a>(x: &'a str) {{ g({literal}, crate::b::make()); }}");
        assert_eq!(ties_of_a(&text), ["a.rs > b.rs: make"], "{literal}");
    }
}

#[test]
fn tests_are_not_counted() {
    assert!(ties_of_a("#[cfg(test)]\nmod tests { use crate::b::Thing; fn f() {} }").is_empty());
    assert!(ties_of_a("#[cfg(test)] use crate::b::Thing;").is_empty());
    assert!(ties_of_a("#[cfg(test)] #[allow(x)] pub(super) fn f(a: [u8; 2]) -> u8 { crate::b::make(); 1 }").is_empty());
    assert!(ties_of_a("struct A { #[cfg(test)] a: crate::b::Thing, b: u8 }").is_empty());
    assert_eq!(ties_of_a("#[cfg(test)] const A: u8 = { 1 }; use crate::b::Thing;"), ["a.rs > b.rs: Thing"]);
    assert_eq!(ties_of_a("#[cfg(not(test))] use crate::b::Thing;"), ["a.rs > b.rs: Thing"]);
}

#[test]
fn a_test_module_in_files_of_its_own_is_not_counted() {
    let (tree, arrows) = read(&[
        ("lib.rs", "#[cfg(test)] mod oracle; mod a;"),
        ("oracle.rs", "mod inner; use crate::a::A;"),
        ("oracle/inner.rs", "use crate::a::A;"),
        ("a.rs", "pub struct A;"),
    ]);
    assert!(tree.faults.is_empty() && arrows.faults.is_empty() && arrows.ties.is_empty(), "{arrows:?}");
    assert_eq!(tree.lines.len(), 2);
}

#[test]
fn nested_braces_and_renamings_are_followed() {
    let text = "use crate::b::{Thing as Other, deep::{self as d, Low}, make};\nfn f() { d::Low::One }";
    assert_eq!(ties_of_a(text), ["a.rs > b.rs: Thing make", "a.rs > b/deep.rs: Low"]);
    assert_eq!(ties_of_a("use crate::b as other; fn f() { other::make() }"), ["a.rs > b.rs: make"]);
    assert_eq!(ties_of_a("use crate::{b::{deep}}; fn f(x: deep::Low) {}"), ["a.rs > b/deep.rs: Low"]);
}

#[test]
fn globs_tie_what_is_named() {
    assert_eq!(ties_of_a("use super::b::*; fn f() { make() }"), ["a.rs > b.rs: make"]);
    assert_eq!(ties_of_a("use crate::b::deep::Low::*; fn f() { One }"), ["a.rs > b/deep.rs: Low"]);
    assert!(ties_of_a("use super::b::*; fn f() { other.make() }").is_empty());
}

#[test]
fn paths_in_code_are_followed() {
    let two = ties_of_a("fn f() -> super::b::deep::Low { g(crate::b::make(), 1) }");
    assert_eq!(two, ["a.rs > b.rs: make", "a.rs > b/deep.rs: Low"]);
    assert_eq!(ties_of_a("struct A(Vec<crate::b::Thing>, fn(&u8) -> u8); pub fn last() {}"), ["a.rs > b.rs: Thing"]);
    assert_eq!(ties_of_a("struct A { #[serde(with = \"crate::b::deep::Low\")] a: u8 }"), ["a.rs > b/deep.rs: Low"]);
    let upward = ties(&[
        ("lib.rs", "mod a; pub fn y() {}"),
        ("a.rs", "mod b;"),
        ("a/b.rs", "fn f() { super::super::y() } mod inline { fn g() { super::super::super::y() } }"),
    ]);
    assert_eq!(upward, ["a/b.rs > lib.rs: y"]);
}

#[test]
fn a_child_module_is_seen_by_its_name() {
    let used = ties(&[("lib.rs", "mod a; fn f() { a::g::<u8>(1); }"), ("a.rs", "pub fn g() {}")]);
    assert_eq!(used, ["lib.rs > a.rs: g"]);
}

#[test]
fn a_program_takes_from_the_library() {
    let main = "fn main() { pivot_cal::a::g() }";
    let used = ties(&[("lib.rs", "pub mod a;"), ("a.rs", "pub fn g() {}"), ("bin/x/main.rs", main)]);
    assert_eq!(used, ["bin/x/main.rs > a.rs: g"]);
}

#[test]
fn a_front_door_is_no_tie() {
    let shown = "mod deep; mod other; pub use deep::Deep; pub(crate) use other::{deep as plan, Other};";
    let files = |front: &'static str| {
        [
            ("lib.rs", "mod front; mod user;"),
            ("front.rs", front),
            ("front/deep.rs", "pub struct Deep;"),
            ("front/other.rs", "pub struct Other; pub fn deep() {}"),
            ("user.rs", "use crate::front::{Deep, Other, plan};"),
        ]
    };
    assert_eq!(ties(&files(shown)), ["user.rs > front/deep.rs: Deep", "user.rs > front/other.rs: Other deep"]);
    let uses = "mod deep; mod other; pub use {deep::Deep, other::{deep as plan, Other}}; fn f() -> Deep { plan() }";
    assert_eq!(ties(&files(uses))[..2], ["front.rs > front/deep.rs: Deep", "front.rs > front/other.rs: deep"]);
}

#[test]
fn a_module_and_a_function_may_share_a_name() {
    let files = |user: &'static str| {
        [
            ("lib.rs", "mod plan; mod user; pub use plan::plan;"),
            ("plan.rs", "mod step; pub fn plan() {} pub use step::Step;"),
            ("plan/step.rs", "pub struct Step;"),
            ("user.rs", user),
        ]
    };
    assert_eq!(ties(&files("use super::plan; fn f(s: plan::Step) {}")), ["user.rs > plan/step.rs: Step"]);
    assert_eq!(ties(&files("use super::plan; fn f() { plan() }")), ["user.rs > plan.rs: plan"]);
}

#[test]
fn a_circle_through_a_front_door_is_found() {
    let (_, arrows) = read(&[
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "mod inner; pub use inner::A;"),
        ("a/inner.rs", "use crate::b::f; pub struct A;"),
        ("b.rs", "pub fn f() { super::c::g() }"),
        ("c.rs", "use crate::a::A; use crate::b; pub fn g() {}"),
    ]);
    let graph = Graph::new(&arrows.ties);
    let circles: Vec<Vec<_>> = graph.circles().into_iter().map(|circle| circle.into_iter().collect()).collect();
    assert_eq!(circles, [["src/a/inner.rs", "src/b.rs", "src/c.rs"]]);
    assert_eq!(graph.longest_chain(), 1);
}

#[test]
fn a_chain_is_measured() {
    let (_, arrows) = read(&[
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::b::b; use crate::c::c;"),
        ("b.rs", "use crate::c::c; pub fn b() {}"),
        ("c.rs", "pub fn c() {}"),
    ]);
    let graph = Graph::new(&arrows.ties);
    assert_eq!((graph.circles().len(), graph.longest_chain()), (0, 3));
}

#[test]
fn what_cannot_be_resolved_is_reported() {
    let faults = |text| read(&[("lib.rs", "mod a;"), ("a.rs", text)]).1.faults;
    assert_eq!(faults("use crate::gone::Thing;"), ["src/a.rs: there is no crate::gone::Thing"]);
    assert_eq!(faults("fn f() { super::gone() }"), ["src/a.rs: there is no super::gone"]);
    assert!(faults("use std::fmt; use serde::{Serialize, de}; fn f() { T::new(); fmt::X; ::a::b() }").is_empty());
    let faults = read(&[("lib.rs", "mod gone;"), ("lost.rs", "")]).0.faults;
    assert_eq!(faults, ["src/lib.rs declares `mod gone;`, which has no file", "src/lost.rs is declared by no module"]);
}

#[test]
fn a_circle_of_front_doors_ends() {
    let (a, b) = ("pub use crate::b::X;", "pub use crate::a::X;");
    let (_, arrows) = read(&[("lib.rs", "mod a; mod b;"), ("a.rs", a), ("b.rs", b)]);
    assert!(arrows.ties.is_empty());
    assert_eq!(arrows.faults.len(), 2);
}

#[test]
fn lines_and_items_are_counted_without_tests() {
    let text = "#[cfg(test)]\nmod oracle;\nuse a::b;\n\npub const fn f() {}\nimpl<const N: u8> A<N> { fn g() {} }\n\
        enum E { A }\n#[cfg(test)]\nmod tests {\n    struct S;\n}\n";
    let read = scan(text);
    assert_eq!(read.lines, 5);
    assert_eq!(read.test_modules, ["oracle"]);
    assert_eq!(read.scope.items.keys().collect::<Vec<_>>(), ["E", "f"]);
}

#[test]
fn a_picture_is_read() {
    let text = "```\nx\n```\n## Floors\n\nwords\n\n```text\na b  top\nc    below\n```\n\
        ```\nno  picture\n```\n## Inside a\n\n```\nd  d\n```\n";
    let drawn = |inside: &str, floors: &[&[&str]]| Picture {
        inside: inside.to_owned(),
        floors: floors.iter().map(|floor| floor.iter().map(|&name| name.to_owned()).collect()).collect(),
    };
    assert_eq!(pictures(text).unwrap(), [drawn("", &[&["a", "b"], &["c"]]), drawn("a", &[&["d"]])]);
    for line in ["a", " a  b", "a, b  c", "a  ", "", "a a  b"] {
        assert!(pictures(&format!("## Floors\n```\n{line}\n```\n")).is_err(), "{line:?}");
    }
}

#[test]
fn imports_that_do_not_point_down_are_reported() {
    let files = [
        ("lib.rs", "mod a; mod b; mod c;"),
        ("a.rs", "use crate::b::b; pub fn a() {}"),
        ("b.rs", "use crate::c::c; pub fn b() {}"),
        ("c.rs", "mod low; mod high; pub use high::c;"),
        ("c/high.rs", "use super::low::l; pub fn c() {}"),
        ("c/low.rs", "pub fn l() {}"),
    ];
    let (tree, arrows) = read(&files);
    let described = |drawn: &str| {
        let pictures = pictures(drawn).unwrap();
        objections(&pictures[0], tree.lines.keys(), &arrows.ties)
    };
    assert!(described("## Floors\n```\na  x\nb  x\nc  x\n```\n").is_empty());
    assert!(described("## Inside c\n```\nhigh  x\nlow   x\n```\n").is_empty());
    let wrong = ["\"d\" is drawn and not there", "a imports b, which is not below it:\n  src/a.rs → src/b.rs: b"];
    assert_eq!(described("## Floors\n```\na b  x\nc d  x\n```\n"), wrong);
    assert_eq!(described("## Inside c\n```\nlow  x\n```\n"), ["\"high\" is not drawn"]);
    assert_eq!(described("## Inside c\n```\nlow  x\nhigh  x\n```\n").len(), 1);
}
