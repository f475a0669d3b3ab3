//! The lateral calibration at the process boundary: logs → table → proof in closed loop, and what is refused.
#![allow(clippy::unwrap_used)]

#[path = "common/program.rs"]
mod program;

use pivot_cal::internals::{LateralTableFile, read_lateral_bytes};
use pivot_cal::map::sha256_hex;
use program::{repo, run};
use std::path::{Path, PathBuf};

/// Base and two angles on the bundled vehicle with its mounting errors.
fn record(folder: &Path, seed: &str, output: &str) {
    let vehicle = repo("data/vehicles/scrubber.toml");
    let args = ["lateral", "record", "--vehicle", &vehicle, "-o", output, "--angles-deg", "-1.5,2", "--seed", seed, "-q"];
    let (status, _, errors) = run(folder, &args);
    assert_eq!(status, 0, "{errors}");
}

fn table(folder: &Path, maps: &str) -> LateralTableFile {
    LateralTableFile::from_json(&std::fs::read_to_string(folder.join(maps).join("lateral_table.json")).unwrap()).unwrap()
}

#[test]
fn the_table_is_what_the_tracking_laws_gain_says_and_does_not_depend_on_the_order_of_the_logs() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder, "1", "logs");
    let logs = ["logs/base.mcap", "logs/compensation_-1.5deg.mcap", "logs/compensation_+2deg.mcap"];
    let fit = |order: [usize; 3], maps: &str, more: &[&str]| {
        let mut args = vec!["lateral", "fit", logs[order[0]], logs[order[1]], logs[order[2]], "--maps", maps, "-q"];
        args.extend(more);
        run(folder, &args)
    };
    assert_eq!(fit([0, 1, 2], "one", &[]).0, 0);
    assert_eq!(fit([2, 0, 1], "two", &[]).0, 0);
    for name in ["lateral_table.csv", "lateral_table.json"] {
        let read = |maps: &str| std::fs::read(folder.join(maps).join(name)).unwrap();
        assert_eq!(read("one"), read("two"), "{name} differs");
    }
    let file = table(folder, "one");
    assert_eq!(file.csv.sha256, sha256_hex(&std::fs::read(folder.join("one/lateral_table.csv")).unwrap()));
    // steady on a straight the law's angle cancels the compensation: atan(L k_e e) = −α, whatever the mounting errors
    // the gain on the offset of the LQR with unit weights and steps of 0.02 m, from the discrete Riccati equation [1/m²]
    let k_e = 0.982_828_628;
    assert_eq!(file.entries.len(), 3);
    for entry in file.entries.iter().filter(|e| e.angle_rad != 0.0) {
        let expected_m = -entry.angle_rad.tan() / (0.9 * k_e);
        // the bends and the settling tails are up to 2 % of an entry; the noise is the standard error's
        let allowed_m = 0.02 * expected_m.abs() + 3.0 * entry.std_err_m;
        assert!((entry.error_m - expected_m).abs() < allowed_m, "{entry:?}: {expected_m}");
        assert!(entry.std_err_m > 1e-6 && entry.std_err_m < 0.001, "{entry:?}");
    }

    // the same logs through a map that names the heading itself
    let signals = "[signals]\npose_x = { path = '/odom.pose.pose.position.x' }\npose_y = { path = '/odom.pose.pose.position.y' }\n\
                   yaw = { path = '/navigation/yaw.data', unit = 'rad' }\nreference_x = { path = '/reference/matched_point.point.x' }\n\
                   reference_y = { path = '/reference/matched_point.point.y' }\ncompensation = { path = '/steering/compensation.data' }\n";
    std::fs::write(folder.join("signals.toml"), signals).unwrap();
    let (status, _, errors) = fit([0, 1, 2], "named", &["--signals", "signals.toml"]);
    assert_eq!(status, 0, "{errors}");
    for (a, b) in table(folder, "named").entries.iter().zip(&file.entries) {
        assert!((a.error_m - b.error_m).abs() < 1e-9, "the quaternion and the heading say the same");
    }

    // a threshold below every entry leaves nothing, and writes nothing
    let (status, _, errors) = fit([0, 1, 2], "none", &["--threshold-m", "0.001"]);
    assert!(status == 1 && errors.contains("0 of 2 entries are left"), "{errors}");
    assert!(!folder.join("none").exists());
    let (status, said, _) = run(folder, &["lateral", "fit", logs[0], logs[1], logs[2], "--maps", "far", "--threshold-m", "0.035"]);
    assert!(status == 0 && said.contains("dropped: at or beyond the threshold of 0.035 m"), "{said}");
    assert_eq!(table(folder, "far").dropped.len(), 1);
}

#[test]
fn what_is_no_calibration_is_refused_with_what_would_be() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    record(folder, "1", "a");
    record(folder, "2", "b");
    let refused = |logs: &[&str], what: &str| {
        let (status, _, errors) = run(folder, &[&["lateral", "fit"], logs].concat());
        assert!(status == 1 && errors.contains(what), "{errors}");
        assert!(!folder.join("maps").exists());
    };
    refused(&["a/compensation_+2deg.mcap"], "none of the 1 log(s) is without compensation");
    refused(&["a/base.mcap", "b/base.mcap", "a/compensation_+2deg.mcap"], "are both without compensation");
    refused(&["a/base.mcap"], "0 of 0 entries are left");
    refused(&[&repo("data/demo.mcap")], "reference");
    let vehicle = repo("data/vehicles/scrubber.toml");
    let (status, _, errors) = run(folder, &["lateral", "record", "--vehicle", &vehicle, "-o", "c", "--angles-deg", "45"]);
    assert!(status == 1 && errors.contains("allowed: −20° to 20°") && !folder.join("c").exists(), "{errors}");
}

/// The repository's maps in a folder of their own.
fn maps(folder: &Path) -> PathBuf {
    let to = folder.join("maps");
    std::fs::create_dir(&to).unwrap();
    for entry in std::fs::read_dir(repo("maps")).unwrap() {
        let from = entry.unwrap().path();
        std::fs::copy(&from, to.join(from.file_name().unwrap())).unwrap();
    }
    to
}

#[test]
fn the_compensation_passes_with_its_table_and_fails_with_one_of_the_wrong_sign() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let to = maps(folder);
    let names = ["lateral-forward", "lateral-reverse", "lateral-forward-periods", "lateral-reverse-periods"];
    let args: Vec<&str> =
        ["verify", "--fresh", "--draws", "1"].into_iter().chain(names.into_iter().flat_map(|name| ["--scenario", name])).collect();
    let (status, said, errors) = run(folder, &args);
    assert_eq!(status, 0, "{said}{errors}");
    // the same entries, angles negated: the compensation drives the vehicle away
    let path = to.join("lateral_table.json");
    let mut file = LateralTableFile::from_json(&std::fs::read_to_string(&path).unwrap()).unwrap();
    file.entries.iter_mut().for_each(|e| e.angle_rad = -e.angle_rad);
    file.curve.angle_rad.iter_mut().for_each(|a| *a = -*a);
    file.csv.sha256 = sha256_hex(file.to_csv().as_bytes());
    std::fs::write(to.join("lateral_table.csv"), file.to_csv()).unwrap();
    std::fs::write(&path, file.to_json().unwrap()).unwrap();
    let (status, said, _) = run(folder, &args);
    assert!(status == 3 && said.contains("mean lateral error, after over before"), "{said}");
    // a CSV that is not the one described
    std::fs::write(to.join("lateral_table.csv"), "mean_lateral_error_m\n").unwrap();
    let (status, _, errors) = run(folder, &args);
    assert!(status == 1 && errors.contains("lateral_table.csv is not the file"), "{errors}");
    std::fs::remove_file(to.join("lateral_table.csv")).unwrap();
    std::fs::remove_file(&path).unwrap();
    let (status, said, _) = run(folder, &args);
    // nothing was tested, so nothing is judged
    assert!(status == 1 && said.contains("there is no lateral_table.json"), "{said}");
}

#[test]
fn every_tracking_law_drives_the_polyline_within_the_gate_and_its_run_is_logged() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    maps(folder);
    let laws = ["pure-pursuit", "front-axle", "rear-axle", "lqr", "mpc"].map(|law| format!("polyline-{law}"));
    let mut args = vec!["verify", "--fresh", "--draws", "1", "--log", "logs", "--json"];
    for name in &laws {
        args.extend(["--scenario", name]);
    }
    let (status, said, errors) = run(folder, &args);
    assert_eq!(status, 0, "{errors}");
    let verdict: serde_json::Value = serde_json::from_str(&said).unwrap();
    for (name, scenario) in laws.iter().zip(verdict["scenarios"].as_array().unwrap()) {
        assert_eq!((scenario["name"].as_str(), scenario["status"].as_str()), (Some(name.as_str()), Some("pass")));
        let figure =
            |metric: &str| scenario["metrics"].as_array().unwrap().iter().find(|m| m["metric"] == metric).unwrap()["nominal"].as_f64();
        // not the perfect zero of a run that measured nothing
        assert!(figure("corner_error_m").unwrap() > 1e-4 && figure("segment_error_m").unwrap() > 1e-3);
        assert!(std::fs::metadata(folder.join("logs").join(format!("{name}.mcap"))).unwrap().len() > 100_000);
    }
    let (_, list, _) = run(folder, &["verify", "--list"]);
    assert!(laws.iter().all(|name| list.contains(name.as_str())) && list.contains("lateral-reverse"));
    let (status, _, errors) = run(folder, &["verify", "--scenario", "polyline-lqg"]);
    assert!(status == 1 && errors.contains("polyline-lqr"), "{errors}");
    // a map of another vehicle is not judged by this one's manoeuvres
    let (status, said, _) =
        run(folder, &["verify", "--scenario", "polyline-lqr", "--vehicle", &repo("data/vehicles/sweeper.toml"), "--draws", "1"]);
    assert!(status == 1 && said.contains("name the map's vehicle with --vehicle"), "{said}");
}

/// The log of `bytes` again, as JSON with arrays of another shape than ROS has.
fn as_json(bytes: Vec<u8>, to: &Path) {
    use pivot_cal::log::{SignalName, Source, VehicleOverrides};
    let recording = read_lateral_bytes(bytes, "ros.mcap", &Source::Detect, &VehicleOverrides::default()).unwrap();
    let signals = &recording.signals;
    let mut writer = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    let channel =
        |writer: &mut mcap::Writer<_>, topic: &str| writer.add_channel(0, topic, "json", &std::collections::BTreeMap::new()).unwrap();
    let (pose, plan, angle) = (channel(&mut writer, "/pose"), channel(&mut writer, "/plan"), channel(&mut writer, "/angle"));
    let mut put = |channel_id, time_ns: i64, json: serde_json::Value| {
        let time = time_ns as u64;
        let header = mcap::records::MessageHeader { channel_id, sequence: 0, log_time: time, publish_time: time };
        writer.write_to_known_channel(&header, json.to_string().as_bytes()).unwrap();
    };
    let of = |name| &signals.lateral[&name];
    for path in &signals.reference_paths {
        let xs: Vec<f64> = path.points_m.iter().map(|p| p[0]).collect();
        let ys: Vec<f64> = path.points_m.iter().map(|p| p[1]).collect();
        put(plan, path.time_ns, serde_json::json!({ "frame": "odom", "xs": xs, "ys": ys }));
    }
    let x = of(SignalName::PoseX);
    for (k, time_ns) in x.time_ns.iter().enumerate() {
        let [x, y, z, w] = [SignalName::PoseX, SignalName::PoseY, SignalName::YawZ, SignalName::YawW].map(|name| of(name).value[k]);
        put(pose, *time_ns, serde_json::json!({ "x": x, "y": y, "yaw": 2.0 * z.atan2(w) }));
    }
    let compensation = of(SignalName::Compensation);
    for (time_ns, value) in compensation.time_ns.iter().zip(&compensation.value) {
        put(angle, *time_ns, serde_json::json!({ "rad": value }));
    }
    writer.finish().unwrap();
    std::fs::write(to, writer.into_inner().into_inner()).unwrap();
}

#[test]
fn the_reference_as_a_whole_path_gives_the_table_of_its_matched_points() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let vehicle = repo("data/vehicles/scrubber.toml");
    for form in ["point", "path"] {
        let args = ["lateral", "record", "--vehicle", &vehicle, "-o", form, "--angles-deg", "-1.5,2", "--reference", form, "-q"];
        assert_eq!(run(folder, &args).0, 0);
        let (status, _, errors) = run(folder, &["lateral", "fit", form, "--maps", &format!("of_{form}"), "-q"]);
        assert_eq!(status, 0, "{errors}");
    }
    let (point, path) = (table(folder, "of_point"), table(folder, "of_path"));
    assert_eq!(path.entries.len(), 3);
    for (a, b) in path.entries.iter().zip(&point.entries) {
        // the same poses, matched to the polyline and not to the curve between its points: 0.1 mm, far below an entry's standard error
        assert!(a.angle_rad == b.angle_rad && (a.error_m - b.error_m).abs() < 1e-4, "{a:?} {b:?}");
        assert!((a.std_err_m - b.std_err_m).abs() < 1e-4 && (a.way_m - b.way_m).abs() <= 1.0, "{a:?} {b:?}");
    }
    assert!((path.base.mean_error_m - point.base.mean_error_m).abs() < 1e-4);

    // the same logs as JSON, arrays of numbers, named by a map
    std::fs::create_dir(folder.join("json")).unwrap();
    for name in ["base.mcap", "compensation_-1.5deg.mcap", "compensation_+2deg.mcap"] {
        as_json(std::fs::read(folder.join("path").join(name)).unwrap(), &folder.join("json").join(name));
    }
    let map = |x: &str, y: &str| {
        let text = format!(
            "[vehicle]\nwheelbase_m = 0.9\nwheel_radius_m = 0.1\ntest_angle_deg = 90\n[signals]\npose_x = {{ path = '/pose.x' }}\n\
             pose_y = {{ path = '/pose.y' }}\nyaw = {{ path = '/pose.yaw' }}\nreference_x = {{ path = '{x}' }}\n\
             reference_y = {{ path = '{y}' }}\ncompensation = {{ path = '/angle.rad' }}\n"
        );
        std::fs::write(folder.join("json.toml"), text).unwrap();
        run(folder, &["lateral", "fit", "json", "--signals", "json.toml", "--maps", "of_json", "-q"])
    };
    let (status, _, errors) = map("/plan.xs[:]", "/plan.ys[:]");
    assert_eq!(status, 0, "{errors}");
    for (a, b) in table(folder, "of_json").entries.iter().zip(&path.entries) {
        assert!((a.error_m - b.error_m).abs() < 1e-9, "{a:?} {b:?}");
    }
    for (x, y, words) in [
        ("/plan.xs[:]", "/pose.y", "both must be slices of one topic"),
        ("/plan.xs[:].a[:]", "/plan.ys[:].a[:]", "followed by another slice or a filter"),
        ("/plan.xs[3:5]", "/plan.ys[9:8]", "gives no value"),
    ] {
        let (status, _, errors) = map(x, y);
        assert!(status == 1 && errors.contains(words), "{errors}");
    }
    // any other signal is one number
    let text = std::fs::read_to_string(folder.join("json.toml")).unwrap().replace("/pose.x", "/plan.xs[0:3]");
    std::fs::write(folder.join("several.toml"), text).unwrap();
    let (status, _, errors) = run(folder, &["lateral", "fit", "json", "--signals", "several.toml"]);
    assert!(status == 1 && errors.contains("pose_x") && errors.contains("it picks several values"), "{errors}");
    // one point is no path
    let (status, _, errors) = map("/plan.xs[2:2]", "/plan.ys[2:2]");
    assert!(status == 1 && errors.contains("overlap in 0 place(s)"), "{errors}");
    let (status, _, errors) = map("/plan.xs[0:-100000]", "/plan.ys[:]");
    assert!(status == 1 && errors.contains("gives no value"), "{errors}");
}

#[test]
fn a_polyline_of_ones_own_is_driven_and_what_is_none_is_refused_with_what_would_be() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    maps(folder);
    let verify = |points: &str, more: &[&str]| {
        std::fs::write(folder.join("points.csv"), points).unwrap();
        run(folder, &[&["verify", "--fresh", "--scenario", "polyline-lqr", "--draws", "1", "--points", "points.csv"], more].concat())
    };
    // off the origin, first to the north, a corner to the left, one back by more than 90° (in reverse)
    let (status, said, errors) = verify("x_m,y_m\n20,10\n20,14\n16,14\n18,12.5\n", &["--json"]);
    assert_eq!(status, 0, "{errors}");
    let verdict: serde_json::Value = serde_json::from_str(&said).unwrap();
    let scenario = &verdict["scenarios"][0];
    assert_eq!((scenario["name"].as_str(), scenario["status"].as_str()), (Some("polyline-lqr"), Some("pass")), "{scenario}");
    assert!(scenario["what"].as_str().unwrap().starts_with("3 given segments"), "{scenario}");
    let traces: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("maps/manoeuvre_traces.json")).unwrap()).unwrap();
    let driven = traces["manoeuvres"][0]["driven_m"].as_array().unwrap();
    let end = |k: usize| [0, 1].map(|c| driven[k][c].as_f64().unwrap());
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 0.03;
    assert!(near(end(0), [20.0, 10.0]) && near(end(driven.len() - 1), [18.0, 12.5]), "{:?} {:?}", end(0), end(driven.len() - 1));

    // with a set speed of 0.3 m/s from the second point on: some 14 s for its 4 m instead of 6 s
    let time_s = |said: &str| {
        let verdict: serde_json::Value = serde_json::from_str(said).unwrap();
        let metrics = verdict["scenarios"][0]["metrics"].as_array().unwrap();
        metrics.iter().find(|m| m["metric"] == "time_s").unwrap()["nominal"].as_f64().unwrap()
    };
    let (status, slow, errors) =
        verify("x_m,y_m,speed_mps\n20,10,\n20,14,0.3\n16,14,\n18,12.5,\n", &["--json", "--log", "logs", "--log-worst"]);
    assert_eq!(status, 0, "{errors}");
    assert!((5.0..12.0).contains(&(time_s(&slow) - time_s(&said))), "{} and {}", time_s(&slow), time_s(&said));
    // the worst of the perturbed runs beside the nominal one, and what the pass is about
    assert!(folder.join("logs/polyline-lqr.mcap").exists() && folder.join("logs/polyline-lqr.worst.mcap").exists());
    let reason = serde_json::from_str::<serde_json::Value>(&slow).unwrap()["reason"].as_str().unwrap().to_owned();
    assert!(reason.contains("manoeuvres prove the path planner and its laws, not the map"), "{reason}");

    std::fs::remove_file(folder.join("maps/verify.json")).unwrap();
    for (points, words) in [
        ("0,0,0.5\n5,0,9\n5,5,\n", "the set speed at point 2 is 9 m/s; allowed: 0.05 to 5 m/s"),
        ("3,4\n", "a path needs at least 2 points, 1 found; add a point at least 0.1 m from the first"),
        ("", "at least 2 points, 0 found"),
        (
            "0,0\n5,0\n5,0\n5,5\n",
            "points 2 and 3 are 0 m apart, at (5, 0); the least is 0.1 m: leave out point 3, or move it by at least 0.1 m",
        ),
        ("0,0\n5,nan\n", "point 2 is not a pair of finite numbers"),
        ("0,0\n5;zwei\n", "line 2"),
    ] {
        let (status, _, errors) = verify(points, &[]);
        assert!(status == 1 && errors.contains("points.csv") && errors.contains(words), "{points:?}: {errors}");
        assert!(!folder.join("maps/verify.json").exists());
    }
    let (status, _, errors) = run(folder, &["verify", "--scenario", "left-90", "--points", "points.csv"]);
    assert!(status == 1 && errors.contains("--points needs a polyline"), "{errors}");
    for (found, nearest) in [("uturn", "u-turn"), ("lateral", "lateral-forward"), ("parkin-60", "parking-60"), ("left90", "left-90")] {
        let (status, _, errors) = run(folder, &["verify", "--scenario", found]);
        assert!(status == 1 && errors.contains(&format!("the nearest is {nearest};")), "{errors}");
    }
}
