//! A verdict that cannot be fooled, at the process boundary: an objection to Table 1 rejects the map, a pass has content, and its first
//! line has its scope.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;

use map_copy::{change_table1, copied, run, text};
use pivot_cal::map::{Check, CheckOutcome, DelayStatus, Gear, SampleVerdict, SpeedSource, Table1File};
use serde_json::Value;
use std::path::Path;

/// Verifies the maps; exit status, first line, everything that was printed.
fn verify(maps: &Path, arguments: &[&str]) -> (i32, String, String) {
    let start = ["verify", "--fresh", "--maps", maps.to_str().unwrap()];
    let (status, out, errors) = run(Path::new("."), &[&start[..], arguments].concat());
    (status, out.lines().next().unwrap_or_default().to_owned(), out + &errors)
}

/// One pivot on few draws.
const SHORT: [&str; 4] = ["--draws", "4", "--scenario", "left-90"];

/// The page's banner and the JSON document of `report`.
fn page(maps: &Path) -> (String, Value) {
    let (status, out, errors) = run(Path::new("."), &["report", "--json", "--maps", maps.to_str().unwrap()]);
    assert_eq!(status, 0, "{errors}");
    (text(maps, "report.html"), serde_json::from_str(&out).unwrap())
}

fn banner(page: &str) -> &str {
    let start = page.find("<section id=\"verdict\">").unwrap();
    &page[start..start + page[start..].find("class=\"figures\"").unwrap()]
}

fn verdict(maps: &Path) -> Value {
    serde_json::from_str(&text(maps, "verify.json")).unwrap()
}

/// The wheelbase was given as 1.15 m instead of 0.90 m.
fn wrong_wheelbase(file: &mut Table1File) {
    file.witnesses[0].scale = 0.783;
}

#[test]
fn a_pass_names_what_was_not_tested_in_its_first_line() {
    let (_folder, maps) = copied();
    let (status, first, all) = verify(&maps, &SHORT);
    assert_eq!(status, 0, "{all}");
    assert_eq!(first, "verdict: pass: 90° only, forward gear only, left turns only, 1 of 26 pivots only; assumed: scale of the torque");
    assert_eq!(verdict(&maps)["scope"][1], "forward gear only");
    assert_eq!(verdict(&maps)["reason"], first.strip_prefix("verdict: ").unwrap());
    change_table1(&maps, |file| file.witnesses.retain(|w| w.name == SpeedSource::Encoder));
    let (status, first, all) = verify(&maps, &["--draws", "4", "--scenario", "left-90", "--scenario", "right-90"]);
    assert_eq!(status, 0, "{all}");
    assert!(first.ends_with("2 of 26 pivots only; assumed: scale of the torque, wheelbase 0.9 m, wheel radius 0.12 m"), "{first}");
}

#[test]
fn an_objection_rejects_the_map_until_a_person_overrules_it_by_name() {
    let (_folder, maps) = copied();
    change_table1(&maps, wrong_wheelbase);
    let (status, first, all) = verify(&maps, &["--draws", "4"]);
    assert_eq!(status, 3, "{all}");
    assert!(
        first.starts_with("verdict: rejected by encoder-scale: ") && first.contains("a difference of 21.7 %, 5 % is allowed"),
        "{first}"
    );
    assert!(first.contains("wheelbase") && first.contains("wheel radius"), "{first}");
    assert_eq!(verdict(&maps)["status"], "rejected");
    let (html, document) = page(&maps);
    assert_eq!(document["judgement"], "rejected");
    assert!(banner(&html).contains("Rejected") && banner(&html).contains("a difference of 21.7 %, 5 % is allowed"), "{}", banner(&html));
    assert!(!html.contains("may be deployed"));

    let (status, _, all) = verify(&maps, &["--accept", "encoder", "--draws", "4"]);
    assert!(status == 1 && all.contains("there is no check \"encoder\" to accept") && all.contains("encoder-scale"), "{all}");
    let (status, first, all) = verify(&maps, &["--accept", "encoder-scale", "--accept", "coverage", "--draws", "20"]);
    assert_eq!(status, 0, "{all}");
    assert!(
        first.starts_with("verdict: pass") && first.contains("overruled by hand: encoder-scale (the encoder's speed is 0.783"),
        "{first}"
    );
    assert!(all.contains("coverage is no objection"), "{all}");
    assert_eq!(verdict(&maps)["accepted"], serde_json::json!(["encoder-scale"]));
    let (html, document) = page(&maps);
    assert_eq!(document["judgement"], "pass");
    assert!(banner(&html).contains("overruled by hand: encoder-scale") && html.contains("objection, overruled by hand"));
}

#[test]
fn a_rejected_fit_never_leads_to_a_page_that_allows_deployment() {
    let (_folder, maps) = copied();
    // stored by the fit, about something that the file does not hold
    let objection = Check {
        name: "logs-agree".to_owned(),
        outcome: CheckOutcome::Objection,
        figure: 14.0,
        limit: 10.0,
        unit: "%".to_owned(),
        meaning: "the same torque accelerates <b.mcap> 14 ± 1 % more than a.mcap, 10 % is allowed".to_owned(),
        advice: "fit them apart".to_owned(),
    };
    change_table1(&maps, |file| file.checks.push(objection));
    // the verdict is that of a version without checks: a pass on this Table 2
    let (html, document) = page(&maps);
    assert_eq!(document["judgement"], "rejected", "{document}");
    assert!(banner(&html).contains("rejected by logs-agree: ") && banner(&html).contains("&lt;b.mcap&gt; 14 ± 1 % more"));
    std::fs::remove_file(maps.join("verify.json")).unwrap();
    let (html, document) = page(&maps);
    assert_eq!(document["judgement"], "rejected", "without a verdict too");
    assert!(!html.contains("may be deployed"));
    let (status, first, _) = verify(&maps, &SHORT);
    assert!(status == 3 && first.contains("logs-agree"), "{first}");
}

#[test]
fn samples_condemned_as_push_reject_the_map_and_other_flaws_warn_on_it() {
    let (_folder, maps) = copied();
    change_table1(&maps, |file| {
        file.actuator.dead_time.status = DelayStatus::WeaklyDetermined;
        file.actuator.dead_time.std_err_s = Some(0.012);
    });
    let (status, _, all) = verify(&maps, &SHORT);
    assert_eq!(status, 0, "{all}");
    assert!(all.contains("warning dead-time: the standard error of the dead time is 12.0 ms, 10 ms is allowed; drive more steps"), "{all}");
    let (html, _) = page(&maps);
    assert!(html.contains("Checks that are not passed") && html.contains("<strong>warning dead-time</strong>"));
    change_table1(&maps, |file| {
        let used = file.report.ledger.iter_mut().find(|row| row.verdict == SampleVerdict::Used).unwrap();
        let mut pushed = used.clone();
        pushed.verdict = SampleVerdict::Push;
        file.report.ledger.push(pushed);
    });
    let (status, first, all) = verify(&maps, &SHORT);
    assert_eq!(status, 3, "{all}");
    assert!(
        first.starts_with("verdict: rejected by push-and-slip: 50 % of the moving samples") && first.contains("40 % is allowed"),
        "{first}"
    );
}

#[test]
fn nothing_driven_or_nothing_tested_is_no_pass() {
    let (_folder, maps) = copied();
    let (status, first, all) = verify(&maps, &["--draws", "0", "--scenario", "left-90"]);
    assert_eq!(status, 1, "{all}");
    assert!(first.starts_with("verdict: not judged: no perturbed vehicle was driven, at least 1 is needed"), "{first}");
    assert_eq!(page(&maps).1["judgement"], "not_judged");
    change_table1(&maps, |file| file.maps.retain(|m| m.gear == Gear::Forward));
    map_copy::change_table2(&maps, |file| file.maps.retain(|m| m.gear == Gear::Forward));
    let (status, first, all) = verify(&maps, &["--draws", "4", "--scenario", "right-90"]);
    assert_eq!(status, 1, "{all}");
    assert!(first.starts_with("verdict: not judged: 0 of 1 scenarios were tested") && first.contains("no reverse table"), "{first}");
    assert_eq!(verdict(&maps)["status"], "not_judged");
}

#[test]
fn a_gear_with_two_driving_torques_or_less_than_20_s_is_not_judged() {
    let (_folder, maps) = copied();
    let few = |file: &mut Table1File, gear: Gear| {
        // as of a file without stored checks: they are judged by its content
        file.checks.clear();
        file.report.runs.retain(|r| r.gear != gear || r.torque_nm <= 0.0 || [20.0, 36.0].contains(&r.torque_nm));
    };
    change_table1(&maps, |file| few(file, Gear::Reverse));
    let (status, first, all) = verify(&maps, &["--draws", "4", "--scenario", "left-90", "--scenario", "right-90"]);
    assert_eq!(status, 0, "{all}");
    assert!(first.contains("forward gear only, left turns only"), "{first}");
    assert!(all.contains("not tested: reverse gear: 2 driving torques were used, 3 are needed"), "{all}");
    change_table1(&maps, |file| few(file, Gear::Forward));
    let (status, first, all) = verify(&maps, &SHORT);
    assert_eq!(status, 1, "{all}");
    assert!(first.starts_with("verdict: not judged: forward gear: 2 driving torques were used, 3 are needed"), "{first}");
    let (html, document) = page(&maps);
    assert_eq!(document["judgement"], "not_judged");
    assert!(banner(&html).contains("2 driving torques were used, 3 are needed") && !html.contains("may be deployed"), "{}", banner(&html));

    let (_folder, maps) = copied();
    change_table1(&maps, |file| file.report.runs.iter_mut().for_each(|r| r.used_s *= 0.1));
    let (status, first, _) = verify(&maps, &SHORT);
    assert_eq!(status, 1);
    assert!(first.contains("8.0 s of motion were used, 20 s are needed"), "{first}");
}

#[test]
fn a_fail_names_the_metric_with_its_value_and_limit() {
    let (folder, maps) = copied();
    let gate = folder.path().join("gate.toml");
    std::fs::write(&gate, "[[limit]]\nclass = \"turn\"\nmetric = \"heading_error_deg\"\nstatistic = \"p99\"\nat_most = 0.05\n").unwrap();
    let (status, first, all) = verify(&maps, &[&SHORT[..], &["--gate", gate.to_str().unwrap()]].concat());
    assert_eq!(status, 3, "{all}");
    assert!(
        first.starts_with("verdict: FAIL: left-90: final heading error (99 %) is 0.") && first.contains("at most 0.05° is allowed"),
        "{first}"
    );
}

#[test]
fn calibrate_rejects_a_wheelbase_that_the_yaw_rate_contradicts() {
    let folder = tempfile::tempdir().unwrap();
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/demo.mcap");
    let (status, out, errors) = run(folder.path(), &["calibrate", log.to_str().unwrap(), "--wheelbase-m", "1.15", "--maps", "maps"]);
    assert_eq!(status, 3, "{out}{errors}");
    let first = out.lines().find(|line| line.starts_with("verdict: ")).unwrap();
    assert!(first.contains("rejected by encoder-scale: ") && first.contains("5 % is allowed"), "{first}");
    let html = text(&folder.path().join("maps"), "report.html");
    assert!(banner(&html).contains("encoder-scale") && !html.contains("may be deployed"));
    let table1 = Table1File::from_json(&text(&folder.path().join("maps"), "table1.json")).unwrap();
    assert!(table1.checks.iter().any(|c| c.name == "coverage") && table1.checks.iter().any(Check::objects));
}
