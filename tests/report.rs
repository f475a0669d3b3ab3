//! The report: what it says, that it is safe and whole, and that a browser shows it.
#![allow(clippy::unwrap_used)]

#[path = "common/program.rs"]
mod program;
#[path = "common/readers.rs"]
mod readers;

use program::{repo, run};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// The maps of the demo log in a folder of their own.
fn maps(folder: &Path) -> PathBuf {
    let maps = folder.join("maps");
    std::fs::create_dir(&maps).unwrap();
    for entry in std::fs::read_dir(repo("maps")).unwrap() {
        let path = entry.unwrap().path();
        // not what somebody has planned with the demo's maps
        if path.extension().is_some_and(|e| e == "json" || e == "csv") && !path.ends_with("plan.json") {
            std::fs::copy(&path, maps.join(path.file_name().unwrap())).unwrap();
        }
    }
    maps
}

/// Makes the report of `maps`; the page and the JSON document.
fn report(maps: &Path) -> (String, Value) {
    let (status, text, errors) = run(Path::new("."), &["report", "--json", "--maps", maps.to_str().unwrap()]);
    assert_eq!(status, 0, "{errors}");
    (std::fs::read_to_string(maps.join("report.html")).unwrap(), serde_json::from_str(&text).unwrap())
}

fn edit(path: &Path, change: impl Fn(&mut Value)) {
    let mut value: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    change(&mut value);
    std::fs::write(path, serde_json::to_string(&value).unwrap()).unwrap();
}

#[test]
fn the_demo_map_is_reported_to_pass_on_one_page_below_3_mb_that_fetches_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    let (page, document) = report(&maps);
    assert_eq!(document["judgement"], "pass", "{document}");
    assert_eq!(document["notes"], serde_json::json!([]));
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    assert_eq!(document["bytes"], page.len());
    assert!(page.contains("It may be deployed on this vehicle."));
    let namespace = "http://www.w3.org/2000/svg";
    assert!(!page.replace(namespace, "").contains("http") && !page.contains("@import") && !page.contains("url(\""), "something is fetched");
    let drawn = page.split("<script").next().unwrap();
    assert!(!drawn.contains("NaN") && !drawn.contains("Infinity") && !drawn.contains(">inf"));
    for id in [
        "table1",
        "table2",
        "coverage",
        "runs",
        "delay",
        "residuals",
        "friction",
        "round-trip",
        "closed-loop",
        "manoeuvres",
        "next",
        "provenance",
    ] {
        assert!(page.contains(&format!("<section id=\"{id}\">")), "{id} is missing");
    }
    let table1: Value = serde_json::from_str(&std::fs::read_to_string(maps.join("table1.json")).unwrap()).unwrap();
    assert!(page.contains(table1["logs"][0]["sha256"].as_str().unwrap()), "the log's hash");
    let choice = &table1["report"]["diagnostics"]["model_choice"];
    assert!(choice["surface_share"].as_f64().unwrap() < 0.5, "the scrubber obeys the physics form: {choice}");
    assert!(
        page.contains("<dt>Surface</dt><dd>physics form ") && page.contains("predicts runs left out"),
        "how much of the surface was taken"
    );
    assert_eq!(page.matches("<tr data-row=").count(), table1["report"]["runs"].as_array().unwrap().len(), "every run is a row");
    assert_eq!(report(&maps).0, page, "the same files give the same bytes");
}

#[test]
fn every_figure_is_a_picture_of_its_own_too() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    let figures = folder.path().join("figures");
    let (status, text, errors) = run(Path::new("."), &["report", "--maps", maps.to_str().unwrap(), "--svg", figures.to_str().unwrap()]);
    assert_eq!(status, 0, "{errors}");
    assert!(!text.contains('#'), "no map of characters in a pipe: {text}");
    for name in
        ["table1-forward", "table2-forward", "coverage-forward", "residuals-forward", "residuals-time", "delay", "pivot", "friction"]
    {
        let svg = std::fs::read_to_string(figures.join(format!("{name}.svg"))).unwrap();
        assert!(svg.starts_with("<svg xmlns=") && svg.trim_end().ends_with("</svg>"), "{name}");
        assert!(!svg.contains("NaN") && svg.matches("<path").count() + svg.matches("<rect").count() > 5, "{name} is empty");
        let (opened, closed) = (svg.matches("<g ").count(), svg.matches("</g>").count());
        assert_eq!(opened, closed, "{name}");
    }
    let (_, text, _) = run(Path::new("."), &["report", "-v", "--maps", maps.to_str().unwrap()]);
    assert!(text.contains("coverage, forward gear") && text.lines().any(|l| l.contains('|') && l.contains("###")), "{text}");
}

#[test]
fn what_is_absent_is_said_and_is_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    for name in ["fit_traces.json", "verify_traces.json"] {
        std::fs::remove_file(maps.join(name)).unwrap();
    }
    let (page, document) = report(&maps);
    assert_eq!(document["judgement"], "pass");
    assert!(page.contains("The traces of the runs are not here") && page.contains("The residuals are not here"));
    assert!(page.contains("The likelihood is not here") && page.contains("The traces of the pivot are not here"));
    std::fs::remove_file(maps.join("verify.json")).unwrap();
    std::fs::remove_file(maps.join("table2.json")).unwrap();
    let (page, document) = report(&maps);
    assert_eq!(document["judgement"], "not_judged");
    assert!(page.contains("There is no Table 2 yet") && page.contains("must not be deployed before they are"));
    std::fs::remove_file(maps.join("table1.json")).unwrap();
    let (status, _, errors) = run(Path::new("."), &["report", "--maps", maps.to_str().unwrap()]);
    assert_eq!(status, 1);
    assert!(errors.contains("table1.json") && errors.contains("fit logs first"), "{errors}");
}

#[test]
fn a_verdict_on_another_table_judges_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    let csv = maps.join("table2.csv");
    let text = std::fs::read_to_string(&csv).unwrap();
    std::fs::write(&csv, text.replacen(",-", ",", 3)).unwrap();
    let (page, document) = report(&maps);
    assert_eq!(document["judgement"], "not_judged", "table2.csv was edited after the verdict");
    assert!(page.contains("table2.csv is not the file that its JSON describes"));
    std::fs::write(&csv, text).unwrap();
    edit(&maps.join("verify.json"), |v| v["table2_csv_sha256"][0] = "0".repeat(64).into());
    assert_eq!(report(&maps).1["judgement"], "not_judged");
}

#[test]
fn a_verdict_on_chosen_scenarios_alone_judges_no_map_unless_it_fails() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    edit(&maps.join("verify.json"), |v| v["scenarios"].as_array_mut().unwrap().truncate(2));
    let (page, document) = report(&maps);
    assert_eq!(document["judgement"], "not_judged");
    assert!(page.contains("verify.json leaves out 24 of the pivots"), "{}", document["notes"]);
    edit(&maps.join("verify.json"), |v| v["status"] = "fail".into());
    assert_eq!(report(&maps).1["judgement"], "fail");
}

/// Some of each kind of manoeuvre driven with the maps, and a plan beside them; the verdict stays the one on the pivots.
fn drive_manoeuvres(maps: &Path) {
    let kept = ["verify.json", "verify_traces.json"].map(|name| (maps.join(name), std::fs::read(maps.join(name)).unwrap()));
    let mut args = vec!["verify", "--fresh", "--maps", maps.to_str().unwrap(), "--draws", "1", "-q"];
    for name in ["polyline-pure-pursuit", "polyline-lqr", "lateral-forward", "parking", "parking-nose-in", "u-turn"] {
        args.extend(["--scenario", name]);
    }
    let (status, _, errors) = run(Path::new("."), &args);
    assert_eq!(status, 0, "{errors}");
    for (path, bytes) in kept {
        std::fs::write(path, bytes).unwrap();
    }
    let run = serde_json::json!({ "gear": "reverse", "torque_nm": -24.0, "start_speed_mps": 0.7, "spin_up_nm": 40.0, "repeats": 2,
        "seconds": 1.6, "gain_nm": 0.0014, "gain_percent": 1.04, "reason": "cells at -24 to 40 N·m <are> known to ±0.22 N·m only" });
    let plan = serde_json::json!({ "seconds": 299.0, "runs": 111, "std_err_nm": 0.134, "std_err_after_nm": 0.087, "entries": [run] });
    let table1 = std::fs::read_to_string(maps.join("table1.json")).unwrap();
    let generation = serde_json::from_str::<serde_json::Value>(&table1).unwrap()["generation"].clone();
    let sha256 = pivot_cal::map::sha256_hex(table1.as_bytes());
    let file = serde_json::json!({
        "format": "pivot-cal/plan", "format_version": 1, "tool_version": "0.1.0", "generation": generation, "table1_sha256": sha256, "plan": plan
    });
    std::fs::write(maps.join("plan.json"), file.to_string()).unwrap();
}

#[test]
fn manoeuvres_and_the_plan_are_shown_with_the_tables_that_they_belong_to_and_only_then() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    let (page, _) = report(&maps);
    assert!(page.contains("No manoeuvre was driven with this Table 2") && page.contains("No runs are planned yet"));
    drive_manoeuvres(&maps);
    let (page, document) = report(&maps);
    assert_eq!((&document["judgement"], &document["notes"]), (&"pass".into(), &serde_json::json!([])));
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
    assert!(page.contains("26 <small>of 26 scenarios"), "manoeuvres are no pivots");
    assert!(page.contains("111 runs in 4 min 59 s") && page.contains("from 0.70 m/s reached with 40.0 N·m"));
    assert!(page.contains("cells at −24 to 40 N·m &lt;are&gt; known"));
    let traces: Value = serde_json::from_str(&std::fs::read_to_string(maps.join("manoeuvre_traces.json")).unwrap()).unwrap();
    let nominal = |manoeuvre: &str, metric: &str| {
        let all = traces["manoeuvres"].as_array().unwrap().iter();
        let metrics = all.map(|m| &m["verdict"]).find(|v| v["name"] == manoeuvre).unwrap()["metrics"].as_array().unwrap();
        metrics.iter().find(|m| m["metric"] == metric).unwrap()["nominal"].as_f64().unwrap()
    };
    for (manoeuvre, metric) in
        [("polyline-lqr", "corner_error_m"), ("lateral-forward", "lateral_before_m"), ("parking", "final_position_m")]
    {
        let shown = format!("<td>{:.1} (", 1e3 * nominal(manoeuvre, metric));
        assert!(page.contains(&shown), "{manoeuvre}: {shown}");
    }
    // the driven path ends where the metric says
    let parking = traces["manoeuvres"].as_array().unwrap().iter().find(|m| m["verdict"]["name"] == "parking").unwrap();
    let last = |points: &Value| {
        points.as_array().unwrap().last().unwrap().as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect::<Vec<_>>()
    };
    let (driven, goal) = (last(&parking["driven_m"]), last(&parking["planned"].as_array().unwrap().last().unwrap()["points_m"]));
    let apart_m = (driven[0] - goal[0]).hypot(driven[1] - goal[1]);
    // both are rounded to a tenth of a millimetre
    assert!((apart_m - nominal("parking", "final_position_m")).abs() < 2e-4, "{apart_m}");
    let errors = traces["manoeuvres"].as_array().unwrap().iter().find(|m| m["verdict"]["name"] == "lateral-forward").unwrap();
    let mean_m = |k: usize| {
        let values: Vec<f64> = errors["errors"][k]["error_m"].as_array().unwrap().iter().map(|e| e.as_f64().unwrap()).collect();
        values[values.len() * 3 / 4..].iter().sum::<f64>() / (values.len() - values.len() * 3 / 4) as f64
    };
    assert!((mean_m(0).abs() - 0.046).abs() < 0.004 && mean_m(1).abs() < 0.004, "before {} and after {}", mean_m(0), mean_m(1));

    // a name in the file cannot leave the folder of the figures
    edit(&maps.join("manoeuvre_traces.json"), |traces| {
        let all = traces["manoeuvres"].as_array_mut().unwrap().iter_mut().map(|m| &mut m["verdict"]["name"]);
        all.filter(|name| **name == "parking").for_each(|name| *name = "../../escaped".into());
    });
    let figures = folder.path().join("deep/figures");
    let (status, _, errors) = run(Path::new("."), &["report", "--maps", maps.to_str().unwrap(), "--svg", figures.to_str().unwrap()]);
    assert_eq!(status, 0, "{errors}");
    let names: Vec<_> = std::fs::read_dir(&figures).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    assert!(names.iter().any(|name| name.starts_with("manoeuvre-escaped-")), "{names:?}");
    assert!(names.contains(&"manoeuvre-u-turn.svg".to_owned()) && !folder.path().join("escaped.svg").exists(), "{names:?}");

    // of other tables they are left out
    edit(&maps.join("manoeuvre_traces.json"), |v| v["table2_csv_sha256"][0] = "0".repeat(64).into());
    edit(&maps.join("plan.json"), |v| v["table1_sha256"] = "0".repeat(64).into());
    let (page, document) = report(&maps);
    assert!(page.contains("No manoeuvre was driven with this Table 2") && page.contains("No runs are planned yet"));
    let notes = document["notes"].to_string();
    assert!(
        notes.contains("manoeuvre_traces.json belongs to another Table 2") && notes.contains("plan.json was made from another"),
        "{notes}"
    );
}

#[test]
fn a_failed_verdict_is_reported_first_with_its_reasons() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    edit(&maps.join("verify.json"), |v| {
        v["status"] = "fail".into();
        v["notes"] = serde_json::json!(["failed: left-90 & <others>"]);
        v["scenarios"][1]["status"] = "fail".into();
    });
    let (page, document) = report(&maps);
    assert_eq!(document["judgement"], "fail");
    assert!(page.contains("It must not be deployed") && page.contains("failed: left-90 &amp; &lt;others&gt;"));
    assert!(page.contains("25 <small>of 26 scenarios"), "the figure behind it");
}

#[test]
fn names_from_the_files_cannot_become_markup() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    let evil = "</script><script>alert(1)</script><img src=x onerror=alert(2)>";
    let changed = |path: &Path, text: &str| {
        let json = serde_json::to_string(evil).unwrap();
        std::fs::write(path, std::fs::read_to_string(path).unwrap().replace(text, &json)).unwrap();
    };
    changed(&maps.join("table1.json"), "\"demo.mcap\"");
    let sha256 = pivot_cal::map::sha256_hex(&std::fs::read(maps.join("table1.json")).unwrap());
    changed(&maps.join("fit_traces.json"), "\"demo.mcap\"");
    edit(&maps.join("fit_traces.json"), |v| v["table1"]["sha256"] = sha256.clone().into());
    let (page, document) = report(&maps);
    assert_eq!(page.matches("<script").count(), 2, "the page's own two");
    assert!(!page.contains("<img"));
    assert!(document["notes"].as_array().unwrap().iter().all(|n| !n.as_str().unwrap().contains("fit_traces")), "{document}");
}

#[test]
fn damaged_and_strange_files_are_errors_with_their_name_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    for (name, text) in [
        ("fit_traces.json", "{"),
        ("fit_traces.json", "{\"format\": \"pivot-cal/fit_traces\", \"format_version\": 9}"),
        ("verify_traces.json", "[]"),
        ("verify.json", "{\"format\": \"pivot-cal/verify\", \"format_version\": 1}"),
    ] {
        let path = maps.join(name);
        let good = std::fs::read(&path).unwrap();
        std::fs::write(&path, text).unwrap();
        let (status, _, errors) = run(Path::new("."), &["report", "--maps", maps.to_str().unwrap()]);
        assert!(status == 1 && errors.contains(name), "{name}: {errors}");
        assert!(!maps.join("report.html").exists());
        std::fs::write(&path, good).unwrap();
    }
    // traces whose lists do not fit together, or are empty, are drawn as far as they go
    edit(&maps.join("fit_traces.json"), |v| {
        v["runs"][0]["t_s"] = serde_json::json!([]);
        v["runs"][1]["row"] = 100_000.into();
        v["residual_cells"][0]["mean_mps2"] = serde_json::json!([[]]);
        v["residual_times"][0]["t_s"] = serde_json::json!([1.0]);
        v["delay"]["deviance"] = serde_json::json!([[0.0]]);
        v["delay"]["per_log"] = serde_json::json!([]);
    });
    edit(&maps.join("verify_traces.json"), |v| v["laws"][0]["speed_mps"]["p05"] = serde_json::json!([]));
    report(&maps);
}

/// A browser that can be driven.
fn browser() -> Option<PathBuf> {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let found = names.iter().find_map(|name| std::env::split_paths(&paths).map(|p| p.join(name)).find(|p| p.is_file()));
    if found.is_none() {
        readers::not_tested("the report in a browser", "there is no Chromium");
    }
    found
}

#[test]
fn a_browser_shows_every_figure_fetches_nothing_and_answers_the_pointer() {
    let Some(browser) = browser() else { return };
    let Some(python) = readers::python(&["websocket"], "the report in a browser") else { return };
    let folder = tempfile::tempdir().unwrap();
    let maps = maps(folder.path());
    drive_manoeuvres(&maps);
    report(&maps);
    let found = readers::read_with(&python, "page.py", &[&browser, &maps.join("report.html")], "");
    assert_eq!(found["requests"], serde_json::json!([]), "nothing but the page itself is loaded");
    assert_eq!(found["errors"], serde_json::json!([]), "the console is silent");
    let figures = found["figures"].as_array().unwrap();
    assert!(figures.len() >= 25, "{} figures", figures.len());
    for name in ["polyline", "polyline-errors", "lateral", "parking", "parking-nose-in", "u-turn"] {
        assert!(figures.iter().any(|f| f["id"] == format!("manoeuvre-{name}")), "{name} has no picture");
    }
    assert_eq!(found["overlaps"], serde_json::json!([]), "names and numbers lie over each other");
    assert_eq!(found["clipped"], serde_json::json!([]), "names and numbers are cut off");
    for figure in figures {
        let large = |key: &str, least: f64| figure[key].as_f64().unwrap() > least;
        assert!(large("shapes", 10.0) && large("width", 200.0) && large("height", 100.0), "{figure} is not drawn");
        assert_eq!(figure["bad"], false, "{figure}");
    }
    assert_eq!(found["verdict"], "Pass");
    // the tip of a cell shows the number in table1.json
    let table1: Value = serde_json::from_str(&std::fs::read_to_string(maps.join("table1.json")).unwrap()).unwrap();
    let map = &table1["maps"][0];
    let accel = map["accel_mps2"][12][4].as_f64().unwrap();
    let tip = found["tip"].as_str().unwrap();
    assert!(tip.contains(&format!("acceleration {accel:.2}").replace('-', "−")), "{tip}: {accel}");
    assert!(tip.contains(&format!("{:.2} m/s", map["speed_mps"][4].as_f64().unwrap())), "{tip}");
    assert!(tip.contains(map["status"][12][4].as_str().unwrap()), "{tip}");
    assert_eq!(found["tip_gone"], true);
    assert_eq!(found["turned"], true, "a surface turns");
    let trace = &found["trace"];
    assert_eq!(trace["bad"], false, "{trace}");
    assert_eq!(trace["titles"].as_array().unwrap().len(), 3, "speed, torque, angle: {trace}");
    assert!(trace["paths"].as_u64().unwrap() >= 4 && trace["dots"].as_u64().unwrap() > 10, "{trace}");
    assert!(trace["bands"].as_array().unwrap().iter().any(|b| b == "used"), "{trace}");
    assert_eq!(found["trace_closed"], true, "a second click closes it");
    let sorted: Vec<f64> =
        found["sorted"].as_array().unwrap().iter().map(|v| v.as_str().unwrap().replace('−', "-").parse().unwrap()).collect();
    assert!(sorted.is_sorted(), "a click on a heading sorts");
    assert_ne!(found["background"], found["dark_background"], "light and dark");
    assert!(found["overflow"].as_f64().unwrap() <= 0.0, "nothing sticks out to the side");
    assert!(found["narrow_overflow"].as_f64().unwrap() <= 0.0, "nor in a narrow window");
    assert!(found["pdf_bytes"].as_u64().unwrap() > 50_000, "it prints");
}
