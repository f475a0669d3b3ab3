//! What to drive next: a campaign that `record` accepts, within its time, that first fills what is missing.

#![allow(clippy::unwrap_used)]

use pivot_cal::fit::{Plan, PlanSettings, plan};
use pivot_cal::map::{Gear, Table1File};
use pivot_cal::record::Campaign;

fn table1() -> Table1File {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("maps/table1.json");
    Table1File::from_json(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn planned(file: &Table1File) -> Plan {
    plan(file, &PlanSettings { budget_s: 20.0 }).unwrap()
}

#[test]
fn a_plan_is_a_campaign_within_its_time_and_the_most_useful_run_comes_first() {
    let file = table1();
    let plan = planned(&file);
    assert_eq!(plan, planned(&file), "the same table gives the same plan");
    let text = plan.to_toml();
    let campaign = Campaign::from_toml(&text).unwrap();
    let runs = campaign.plan(1).unwrap();
    assert_eq!(runs.len(), plan.runs as usize);
    let limit_nm = file.vehicle.torque_limit_nm.unwrap();
    assert!(runs.iter().all(|r| r.torque_nm.abs() <= limit_nm && r.settings.spin_up_nm <= limit_nm));
    assert!(plan.seconds <= 20.0 && plan.seconds > 14.0, "{} s", plan.seconds);
    assert!(plan.std_err_after_nm < plan.std_err_nm);
    let first = plan.entries[0].gain_nm_per_s;
    assert!(plan.entries.iter().all(|e| e.gain_nm_per_s > 0.0 && e.gain_nm_per_s <= first));
    assert!(plan.entries.iter().all(|e| text.contains(&e.reason) && e.reason.contains("known to ±")));
}

#[test]
fn braking_that_is_missing_is_driven_first() {
    let mut file = table1();
    // both gears: what one gear does the other mostly does too
    file.report.runs.retain(|r| r.torque_nm > 4.5);
    let missing = planned(&file);
    let known = planned(&table1());
    assert!(missing.std_err_nm > 1.2 * known.std_err_nm, "{} {}", missing.std_err_nm, known.std_err_nm);
    // every run ends in a coast; what is chosen beside it is braking
    let first = &missing.entries[0];
    assert!(first.torque_nm < 4.5 && first.start_speed_mps > 0.3, "{first:?}");
}

#[test]
fn one_gear_that_was_hardly_driven_comes_first() {
    let mut file = table1();
    let mut kept = 0;
    file.report.runs.retain(|r| {
        kept += u32::from(r.gear == Gear::Reverse);
        r.gear == Gear::Forward || kept <= 3
    });
    assert_eq!(planned(&file).entries[0].gear, Gear::Reverse);
}

#[test]
fn what_cannot_be_planned_is_told() {
    let told = plan(&table1(), &PlanSettings { budget_s: 1.0 }).unwrap_err().to_string();
    assert!(told.contains("no run fits"), "{told}");
    let mut file = table1();
    file.report.runs.clear();
    let told = plan(&file, &PlanSettings::default()).unwrap_err().to_string();
    assert!(told.contains("Drive a first campaign"), "{told}");
}
