//! Maps of a vehicle whose plant is known, for the tests of this module.

use crate::map::{Gear, Table1File, Table2File, Vehicle};
use crate::sim::{PhysicalSettings, WorldSettings};
use crate::verify::reference_maps::known_maps;

/// Table 1 and Table 2 of the forward gear.
pub(crate) fn known() -> (Table1File, Table2File) {
    let vehicle =
        Vehicle { wheelbase_m: 0.92, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: Some(44.0), torque_full_scale_nm: None };
    let (mut table1, mut table2) = known_maps(&WorldSettings::physical(vehicle, PhysicalSettings::default())).expect("a sound vehicle");
    table1.maps.retain(|m| m.gear == Gear::Forward);
    table2.maps.retain(|m| m.gear == Gear::Forward);
    (table1, table2)
}
