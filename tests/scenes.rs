//! Scene files: `verify --scene` drives what the file says, stores it with its hash and shows it; a scene that cannot be planned is an error.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::{copied, run, text};
use pivot_cal::map::sha256_hex;
use serde_json::Value;
use std::path::Path;

fn example(name: &str) -> String {
    text(Path::new(env!("CARGO_MANIFEST_DIR")), &format!("data/scenes/{name}.toml"))
}

fn json(maps: &Path, file: &str) -> Value {
    serde_json::from_str(&text(maps, file)).unwrap()
}

fn scenario<'a>(verdict: &'a Value, name: &str) -> &'a Value {
    verdict["scenarios"].as_array().unwrap().iter().find(|s| s["name"] == name).unwrap()
}

fn trace<'a>(traces: &'a Value, name: &str) -> &'a Value {
    traces["manoeuvres"].as_array().unwrap().iter().find(|m| m["verdict"]["name"] == name).unwrap()
}

#[test]
fn the_examples_are_driven_stored_with_their_hash_and_shown() {
    let (folder, maps) = copied();
    let names = ["dock", "yard", "round", "aisle"];
    let mut arguments = vec!["verify".to_owned(), "--draws".to_owned(), "2".to_owned()];
    for name in names {
        std::fs::write(folder.path().join(format!("{name}.toml")), example(name)).unwrap();
        arguments.extend(["--scene".to_owned(), format!("{name}.toml")]);
    }
    let (status, said, errors) = run(folder.path(), &arguments.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(status, 0, "{said}{errors}");
    let verdict = json(&maps, "verify.json");
    for name in names {
        let driven = scenario(&verdict, name);
        assert_eq!(driven["status"], "pass", "{name}: {driven}");
        assert_eq!(driven["scene"]["sha256"], sha256_hex(example(name).as_bytes()));
    }
    assert_eq!(scenario(&verdict, "dock")["scene"]["scene"]["parking"]["slot"]["width_m"], 1.35);
    let traces = json(&maps, "manoeuvre_traces.json");
    // the pallet, the turn to the right that ends behind the fence, the last of the points
    assert!(trace(&traces, "dock")["obstacles_m"].as_array().unwrap().iter().any(|o| o.to_string().contains("[0.9,3.1]")));
    let end_of = |name: &str| trace(&traces, name)["driven_m"].as_array().unwrap().last().unwrap().clone();
    let near = |at: &Value, x_m: f64, y_m: f64| (at[0].as_f64().unwrap() - x_m).hypot(at[1].as_f64().unwrap() - y_m);
    assert!(end_of("yard")[1].as_f64().unwrap() < 2.6, "{}", end_of("yard"));
    assert!(near(&end_of("round"), 1.0, 3.2) < 0.03, "{}", end_of("round"));
    assert!(end_of("aisle")[0].as_f64().unwrap() < -40.0, "in reverse: {}", end_of("aisle"));

    assert_eq!(run(folder.path(), &["report"]).0, 0);
    let page = text(folder.path(), "maps/report.html");
    for name in names {
        assert!(page.contains(&sha256_hex(example(name).as_bytes())), "{name}");
    }
}

#[test]
fn another_scene_of_the_same_name_is_another_verdict_and_the_verdict_on_pivots_stays() {
    let (folder, maps) = copied();
    let drive = |file: &str| {
        std::fs::write(folder.path().join("scene.toml"), file).unwrap();
        let (status, said, errors) = run(folder.path(), &["verify", "--draws", "1", "--scene", "scene.toml"]);
        assert!(status == 0 || status == 3, "{said}{errors}");
        json(&maps, "verify.json")
    };
    let clearance = |verdict: &Value| {
        let metrics = scenario(verdict, "dock")["metrics"].as_array().unwrap().clone();
        metrics.iter().find(|m| m["metric"] == "clearance_m").unwrap()["nominal"].as_f64().unwrap()
    };
    let usual = drive(&example("dock"));
    let pivots = |verdict: &Value| verdict["scenarios"].as_array().unwrap().iter().filter(|s| s["scene"].is_null()).count();
    assert!(pivots(&usual) > 10, "those of the folder's verdict are kept");
    // the pallet reaches further into the aisle than the vehicle's usual distance from the row
    let nearer = drive(&example("dock").replace("[-0.9, 3.1], [0.9, 3.1]", "[-0.9, 2.22], [0.9, 2.22]"));
    assert!(clearance(&nearer) < clearance(&usual) - 0.03, "{} and {}", clearance(&nearer), clearance(&usual));
    assert_eq!(nearer["scenarios"].as_array().unwrap().iter().filter(|s| s["name"] == "dock").count(), 1);
    assert_eq!(pivots(&nearer), pivots(&usual));
}

#[test]
fn a_scene_that_cannot_be_driven_is_an_error_before_the_driving() {
    let (folder, maps) = copied();
    let before = text(&maps, "verify.json");
    for (file, found) in [
        (example("dock").replace("width_m = 1.35", "width_m = 1.0"), "scene.toml: line 15: parking.slot.width_m: the slot is 1.000 m wide"),
        (
            example("dock").replace("name = \"dock\"", "name = \"parking\""),
            "scene.toml: the name \"parking\" is that of a scenario of the program",
        ),
        ("name = \"none\"\n".to_owned(), "scene.toml: the file holds 0 of the sections"),
    ] {
        std::fs::write(folder.path().join("scene.toml"), file).unwrap();
        let (status, _, errors) = run(folder.path(), &["verify", "--scene", "scene.toml"]);
        assert!(status == 1 && errors.contains(found), "{errors}");
    }
    std::fs::write(folder.path().join("scene.toml"), example("dock")).unwrap();
    let (status, _, errors) = run(folder.path(), &["verify", "--scene", "scene.toml", "--scene", "scene.toml"]);
    assert!(status == 1 && errors.contains("two scenes are named dock"), "{errors}");
    assert_eq!(text(&maps, "verify.json"), before);
}
