//! The result of an inversion: `table2.json` and its CSVs.

use crate::invert::delivered_torque::DeliveredTorque;
use crate::invert::inverse::Inverse;
use crate::invert::round_trip::round_trip;
use crate::invert::{Error, InvertSettings, Result, breaks, optimal, raw};
use crate::map::{
    AccelMap, Axis, CellStatus, CsvRef, DeadBand, FORMAT_VERSION, Gear, IdentifiedDrive, RawUnits, TABLE2_FORMAT, Table1File, Table2File,
    TorqueMap, TorqueTable, Units, ZeroRow, csv_name, sha256_hex,
};

/// Share of the largest torque driven by which a node may lie beyond it.
const BEYOND_LARGEST: f64 = 0.05;

/// Table 2 with its files.
#[derive(Debug, Clone)]
pub struct Inversion {
    /// `table2.json`.
    pub file: Table2File,
    /// Name and text of each CSV beside it.
    pub csvs: Vec<(String, String)>,
}

/// Inverts every table of `file`. `table1` names the JSON that it was read from, with its hash.
///
/// # Errors
/// No table, a table that does not rise with torque, breaks that are not a valid axis, a programme that does not finish.
pub fn invert(file: &Table1File, table1: CsvRef, settings: &InvertSettings) -> Result<Inversion> {
    if file.maps.is_empty() {
        return Err(Error::NoTables);
    }
    if let Some(found) = settings.place.into_iter().flatten().find(|n| !(3..=200).contains(n)) {
        return Err(Error::BadPlace { found });
    }
    let limit_nm = file.torque_limit_nm();
    let raw = settings.raw.units(largest(file, settings, limit_nm)?)?;
    let mut maps = Vec::new();
    let mut csvs = Vec::new();
    for map in &file.maps {
        let other = file.maps.iter().find(|m| m.gear != map.gear && m.angle().is_same(map.angle()));
        // where no limit of the vehicle is given, the nodes next to the reach may lie beyond the largest torque driven, so that the table is right
        // up to it; a drive with a limit of its own delivers no more there
        let node_limit_nm = if file.torque_limit_driven { limit_nm * (1.0 + BEYOND_LARGEST) } else { limit_nm };
        let limit = DeliveredTorque {
            least_nm: -limit_nm,
            most_nm: &|v| file.most_torque_nm(v),
            is_governed: &|v| file.is_governed(v),
            node_limit_nm,
        };
        let (inverted, csv) = invert_map(map, other, &limit, &raw, file.vehicle.test_angle_deg, settings)?;
        csvs.push((inverted.csv.file.clone(), csv));
        maps.push(inverted);
    }
    let file = Table2File {
        format: TABLE2_FORMAT.to_owned(),
        format_version: FORMAT_VERSION,
        tool_version: env!("CARGO_PKG_VERSION").to_owned(),
        generation: file.generation.clone(),
        unverified: None,
        units: Units::default(),
        vehicle: file.vehicle,
        logs: file.logs.clone(),
        table1,
        settings: serde_json::to_value(settings).map_err(crate::map::Error::from)?,
        dead_time_s: file.actuator.dead_time.value_s,
        lag_s: file.actuator.lag.value_s,
        drive: file.actuator.drive.clone().map(|drive| IdentifiedDrive { compared: Vec::new(), ..drive }),
        raw: Some(raw).filter(|raw| !raw.is_none()),
        maps,
        families: file.families.clone(),
    };
    Ok(Inversion { file, csvs })
}

/// Largest speed [m/s], acceleration [m/s²] and torque [N·m] of the tables, for the raw units.
fn largest(file: &Table1File, settings: &InvertSettings, limit_nm: f64) -> Result<[f64; 3]> {
    let (mut speed, mut accel) = (0.0f64, 0.0f64);
    for map in &file.maps {
        let inverse = Inverse::new(map.surface.table()?, map.gear)?;
        let speeds = settings.speed_breaks_mps.as_ref().unwrap_or(&map.speed_mps);
        speed = speeds.last().copied().unwrap_or(0.0).max(speed);
        accel = raw::largest_accel_mps2(&inverse, &map.speed_mps, [map.torque_nm[0], map.torque_nm[map.torque_nm.len() - 1]]).max(accel);
    }
    let given = settings.accel_breaks_mps2.iter().flatten().map(|a| a.abs());
    Ok([speed, given.fold(accel, f64::max), limit_nm * (1.0 + BEYOND_LARGEST)])
}

fn invert_map(
    map: &AccelMap,
    other: Option<&AccelMap>,
    limit: &DeliveredTorque,
    raw: &RawUnits,
    test_angle_deg: f64,
    settings: &InvertSettings,
) -> Result<(TorqueMap, String)> {
    let inverse = Inverse::new(map.surface.table()?, map.gear)?;
    let tested = [map.torque_nm[0], map.torque_nm[map.torque_nm.len() - 1]].map(|u| limit.clamp(0.0, u));
    let [low_mps2, high_mps2] = breaks::accel_range_mps2(&inverse, &map.speed_mps, tested);
    if high_mps2.max(-low_mps2) > breaks::MOST_ACCEL_MPS2 {
        return Err(Error::NotPhysical { gear: map.gear, low_mps2, high_mps2, most_mps2: breaks::MOST_ACCEL_MPS2 });
    }
    let (speeds, accels) = axes(&inverse, map, tested, settings);
    let speeds = raw::snapped("speed", map.gear, &speeds, raw.speed_mps)?;
    let accels = raw::snapped("acceleration", map.gear, &accels, raw.accel_mps2)?;
    let speed_axis = Axis::new("speed_mps", speeds.clone())?;
    let accel_axis = Axis::new("accel_mps2", accels.clone())?;

    let mut nodes = if settings.node_exact {
        speeds.iter().flat_map(|v| inverse.torques_nm(*v, &accels).into_iter().map(|u| limit.clamp(*v, u))).collect()
    } else {
        optimal::nodes(&inverse, &speeds, &accels, tested, limit).ok_or(Error::NotSolved { gear: map.gear })?
    };
    if settings.zero_row == ZeroRow::Hold && speeds[0] == 0.0 {
        for (torque, a) in nodes.iter_mut().zip(&accels) {
            if *a <= 0.0 {
                *torque = 0.0;
            }
        }
    }
    for torque in &mut nodes {
        *torque = match raw.torque_nm {
            Some(unit) => raw::snapped_torque(map.gear, *torque, limit.node_limit_nm, unit)?,
            None => round6(*torque),
        };
    }
    let table = TorqueTable::new(speed_axis, accel_axis, nodes)?;
    let inverted = described(&inverse, (map, other), limit, &table, test_angle_deg, settings.zero_row)?;
    Ok((inverted, table.to_matrix().to_csv()))
}

/// Tables that somebody else made, described by Table 1: status, standard error and round trip of each cell. A gear that Table 1 does not have
/// is left out.
///
/// # Errors
/// A Table 1 that does not rise with torque.
pub(crate) fn described_tables(file: &Table1File, tables: &[(Gear, TorqueTable)], zero_row: ZeroRow) -> Result<Vec<TorqueMap>> {
    let limit_nm = file.torque_limit_nm();
    let limit = DeliveredTorque {
        least_nm: -limit_nm,
        most_nm: &|v| file.most_torque_nm(v),
        is_governed: &|v| file.is_governed(v),
        node_limit_nm: limit_nm,
    };
    let angle = file.vehicle.test_angle();
    let mut maps = Vec::new();
    for (gear, table) in tables {
        let Some(map) = file.map(*gear, angle) else { continue };
        let other = file.maps.iter().find(|m| m.gear != *gear && m.angle().is_same(angle));
        let inverse = Inverse::new(map.surface.table()?, map.gear)?;
        maps.push(described(&inverse, (map, other), &limit, table, file.vehicle.test_angle_deg, zero_row)?);
    }
    Ok(maps)
}

/// What Table 1 says of each cell of `table`.
fn described(
    inverse: &Inverse,
    (map, other): (&AccelMap, Option<&AccelMap>),
    limit: &DeliveredTorque,
    table: &TorqueTable,
    test_angle_deg: f64,
    zero_row: ZeroRow,
) -> Result<TorqueMap> {
    let (speeds, accels) = (table.speed_mps().breaks().to_vec(), table.accel_mps2().breaks().to_vec());
    let tested = [map.torque_nm[0], map.torque_nm[map.torque_nm.len() - 1]].map(|u| limit.clamp(0.0, u));
    let csv = table.to_matrix().to_csv();
    let reach: Vec<[f64; 2]> = speeds.iter().map(|v| limit.reach_nm(*v).map(|u| round6(inverse.accel_mps2(*v, u)))).collect();
    let known = map.table()?;
    let status_of = |v: f64, torque: f64| {
        let beyond = torque < tested[0] - 1e-9 || torque > tested[1] + 1e-9 || v > known.speed_mps().last() + 1e-9;
        if beyond { CellStatus::Extrapolated } else { map.status[known.torque_nm().nearest(torque)][known.speed_mps().nearest(v)] }
    };
    let status: Vec<Vec<CellStatus>> =
        speeds
            .iter()
            .zip(&reach)
            .map(|(v, [low, high])| {
                accels
                    .iter()
                    .map(|a| {
                        if *a < *low - 1e-9 || *a > *high + 1e-9 {
                            CellStatus::Unreachable
                        } else {
                            status_of(*v, inverse.torque_nm(*v, *a))
                        }
                    })
                    .collect()
            })
            .collect();
    let errors = crate::map::AccelTable::new(known.speed_mps().clone(), known.torque_nm().clone(), map.std_err_mps2.concat())?;
    let std_err_nm = speeds
        .iter()
        .enumerate()
        .map(|(i, v)| {
            accels
                .iter()
                .enumerate()
                .map(|(j, a)| {
                    let torque = inverse.torque_nm(*v, *a);
                    // a node differs from the inverse at its place to be best between the nodes
                    let moved = table.at(i, j) - torque;
                    (status[i][j] != CellStatus::Unreachable)
                        .then(|| errors.accel_from_torque_clamped(*v, torque))
                        .flatten()
                        .map(|e| round6((e / inverse.slope(*v, torque)).hypot(moved)))
                })
                .collect()
        })
        .collect();
    let trip = round_trip(inverse, table, &status, |v, u| status_of(v, u) == CellStatus::Measured);
    Ok(TorqueMap {
        gear: map.gear,
        wheel_angle_deg: map.wheel_angle_deg,
        csv: CsvRef { file: csv_name("table2", map.gear, map.wheel_angle_deg, test_angle_deg), sha256: sha256_hex(csv.as_bytes()) },
        speed_mps: speeds,
        torque_nm: table.values().chunks(accels.len()).map(<[f64]>::to_vec).collect(),
        accel_mps2: accels,
        std_err_nm,
        status,
        reachable_accel_mps2: reach,
        dead_band: dead_band(map, other),
        zero_row,
        round_trip: trip,
    })
}

/// Breaks as given, placed, or by default.
fn axes(inverse: &Inverse, map: &AccelMap, tested: [f64; 2], settings: &InvertSettings) -> (Vec<f64>, Vec<f64>) {
    let even_speeds = settings.speed_breaks_mps.clone().unwrap_or_else(|| map.speed_mps.clone());
    let even_accels = settings.accel_breaks_mps2.clone().unwrap_or_else(|| breaks::accel_breaks(inverse, &even_speeds, tested));
    let Some([rows, columns]) = settings.place else { return (even_speeds, even_accels) };
    let fastest = even_speeds[even_speeds.len() - 1].min(inverse.fastest_mps());
    let (low, high) = (even_accels[0], even_accels[even_accels.len() - 1]);
    let at_accel = |share: f64| move |v: f64| inverse.torque_nm(v, low + share * (high - low)).clamp(tested[0], tested[1]);
    let at_speed = |share: f64| move |a: f64| inverse.torque_nm(share * fastest, a).clamp(tested[0], tested[1]);
    let (a1, a2, a3) = (at_accel(0.3), at_accel(0.5), at_accel(0.7));
    let (s1, s2, s3) = (at_speed(0.1), at_speed(0.4), at_speed(0.8));
    let speeds = if settings.speed_breaks_mps.is_some() { even_speeds } else { breaks::placed(0.0, fastest, rows, &[&a1, &a2, &a3]) };
    let accels = if settings.accel_breaks_mps2.is_some() { even_accels } else { breaks::placed(low, high, columns, &[&s1, &s2, &s3]) };
    (speeds, accels)
}

/// Torques that leave a resting wheel at rest: up to its breakaway torque, and backward to that of the other gear, or to the same if the
/// other gear was not tested.
fn dead_band(map: &AccelMap, other: Option<&AccelMap>) -> DeadBand {
    let own = &map.breakaway;
    let back = other.map_or(own.torque_nm, |o| o.breakaway.torque_nm);
    DeadBand { low_nm: if back == 0.0 { 0.0 } else { -back }, high_nm: own.torque_nm, std_err_nm: own.std_err_nm }
}

fn round6(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn beyond_a_governor_nothing_accelerates_and_everything_brakes_as_before() {
        let mut file: serde_json::Value = serde_json::from_str(include_str!("../../maps/table1.json")).unwrap();
        let of = |file: &serde_json::Value| {
            let table1 = CsvRef { file: "table1.json".to_owned(), sha256: String::new() };
            invert(&serde_json::from_value(file.clone()).unwrap(), table1, &InvertSettings::default()).unwrap().file
        };
        let free = of(&file);
        file["actuator"]["drive"] = serde_json::json!({ "family": "first-order", "limit": { "kind": "speed", "value": 0.6 } });
        let governed = of(&file);
        for (governed, free) in governed.maps.iter().zip(&free.maps) {
            assert_eq!(governed.torque_nm, free.torque_nm, "the nodes keep their torque");
            for (i, v) in governed.speed_mps.iter().enumerate() {
                for (j, torque_nm) in free.torque_nm[i].iter().enumerate() {
                    let (governed, free) = (governed.status[i][j], free.status[i][j]);
                    if *v > 0.66 && *torque_nm > 0.3 {
                        assert_eq!(governed, CellStatus::Unreachable, "{v} m/s, {torque_nm} N·m");
                    } else if *v < 0.66 || *torque_nm < -0.3 {
                        assert_eq!(governed, free, "{v} m/s, {torque_nm} N·m");
                    }
                }
            }
        }
    }
}
