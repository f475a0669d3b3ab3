//! The manoeuvres: name, description, class and task.

use crate::control::CompensationSettings;
use crate::guidance::path::PosePath;
use crate::guidance::route::polyline::{PolylinePlan, PolylinePoint, PolylineSettings};
use crate::guidance::route::tracking::LawName;
use crate::manoeuvre::Result;
use crate::manoeuvre::compensation_run::{CompensationScenario, PERIODS};
use crate::manoeuvre::planned_task::{Planned, PlannedTask};
use crate::manoeuvre::polyline_run::{DEMO_SPEEDS_MPS, demo_points};
use crate::map::Gear;
use crate::scene::SceneFile;
use crate::sim;
use crate::verify::{Class, Maps};
use serde::Serialize;

/// Task of a manoeuvre.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ManoeuvreKind {
    /// A polyline with turns on the spot, its segments tracked by a law.
    Polyline {
        /// The law.
        law: LawName,
        /// The points, with the set speeds of their segments.
        points: Vec<PolylinePoint>,
        /// Settings of the plan.
        settings: PolylineSettings,
    },
    /// A path with mounting errors, without and with compensation.
    Compensation(CompensationScenario),
    /// A path that is planned beforehand: parking, the U-turn.
    Planned(PlannedTask),
}

/// One manoeuvre.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Manoeuvre {
    /// Its name on the command line.
    pub name: String,
    /// Description.
    pub what: String,
    /// Class; it determines the limits.
    pub class: Class,
    /// Task.
    pub kind: ManoeuvreKind,
    /// The file that it was read from, if it is none of the program's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<SceneFile>,
}

impl Manoeuvre {
    /// Every manoeuvre, in display order.
    pub fn all() -> Vec<Self> {
        let mut all: Vec<Self> = LawName::ALL
            .into_iter()
            .map(|law| Self {
                name: format!("polyline-{}", law.name()),
                what: format!("8 segments with turns on the spot, forward and reverse, tracked by {}", law.title()),
                class: Class::Polyline,
                kind: ManoeuvreKind::Polyline { law, points: demo_points(), settings: PolylineSettings::default() },
                scene: None,
            })
            .collect();
        let speeds = demo_points().into_iter().zip(DEMO_SPEEDS_MPS);
        all.push(Self {
            name: "polyline-speeds".to_owned(),
            what: "the same segments, each with a set speed of its own, tracked by LQR at set speeds".to_owned(),
            class: Class::Polyline,
            kind: ManoeuvreKind::Polyline {
                law: LawName::Lqr,
                points: speeds.map(|(point, speed_mps)| PolylinePoint { speed_mps, ..point }).collect(),
                settings: PolylineSettings::default(),
            },
            scene: None,
        });
        let by_distance = CompensationSettings::default().accumulation;
        for (accumulation, suffix, by) in [(by_distance, "", ""), (PERIODS, "-periods", ", means by control periods")] {
            for direction in Gear::ALL {
                all.push(Self {
                    name: format!("lateral-{direction}{suffix}"),
                    what: format!("mounting yaw off by 1.0° and steering zero off by 0.8°, compensated, in {direction} gear{by}"),
                    class: Class::Compensation,
                    kind: ManoeuvreKind::Compensation(CompensationScenario { accumulation, ..CompensationScenario::new(direction) }),
                    scene: None,
                });
            }
        }
        let parking = |name: &str, what: &str, angle_deg: f64, obstacle_right: bool, nose_in: bool| Self {
            name: name.to_owned(),
            what: what.to_owned(),
            class: Class::Parking,
            kind: ManoeuvreKind::Planned(PlannedTask::Parking { angle_deg, obstacle_right, nose_in }),
            scene: None,
        };
        all.push(parking("parking", "backing into a perpendicular slot between two obstacles", 90.0, true, false));
        all.push(parking("parking-open", "the same without an obstacle on the right: the smallest circle", 90.0, false, false));
        all.push(parking("parking-60", "backing into a slot slanted by 60° against the row", 60.0, true, false));
        all.push(parking("parking-120", "backing into a slot slanted by 120° against the row", 120.0, true, false));
        all.push(parking("parking-nose-in", "forward into a slot slanted by 120° against the row", 120.0, true, true));
        all.push(Self {
            name: "parking-published".to_owned(),
            what: "as parking, by the published line and circle: through the vehicle, and of the smallest radius".to_owned(),
            class: Class::Parking,
            kind: ManoeuvreKind::Planned(PlannedTask::ParkingPublished),
            scene: None,
        });
        all.push(Self {
            name: "parking-shuffle".to_owned(),
            what: "backing into a slot from a narrow aisle, askew, with a large turning circle".to_owned(),
            class: Class::Parking,
            kind: ManoeuvreKind::Planned(PlannedTask::ParkingShuffle),
            scene: None,
        });
        all.push(Self {
            name: "u-turn".to_owned(),
            what: "U-turn around a shelf into the next aisle, with the largest margin that a search finds".to_owned(),
            class: Class::UTurn,
            kind: ManoeuvreKind::Planned(PlannedTask::UTurn),
            scene: None,
        });
        all
    }

    /// The manoeuvre of a scene file.
    pub fn of_scene(file: SceneFile) -> Self {
        let scene = file.scene();
        let (class, kind) = if let Some(keys) = &scene.polyline {
            (Class::Polyline, ManoeuvreKind::Polyline { law: keys.law(), points: keys.points(), settings: keys.settings() })
        } else if let Some(keys) = &scene.lateral {
            (Class::Compensation, ManoeuvreKind::Compensation(CompensationScenario::of_route(keys)))
        } else {
            let class = if scene.parking.is_some() { Class::Parking } else { Class::UTurn };
            (class, ManoeuvreKind::Planned(PlannedTask::Given(Box::new(scene.clone()))))
        };
        Self { name: scene.name().to_owned(), what: scene.what(), class, kind, scene: Some(file) }
    }

    /// The same along other points, if it is a polyline.
    ///
    /// # Errors
    /// Points that are not a path, with the nearest valid choice.
    pub fn along(mut self, points: &[PolylinePoint]) -> Result<Self> {
        if let ManoeuvreKind::Polyline { law, points: own, settings } = &mut self.kind {
            let plan = PolylinePlan::new(points, settings)?;
            self.what = format!("{} given segments with turns on the spot, tracked by {}", plan.segments.len(), law.title());
            *own = points.to_vec();
        }
        Ok(self)
    }

    /// The reason why it cannot be run, if there is one.
    pub(crate) fn reason_against(&self, maps: &Maps, plant: &sim::WorldSettings) -> Option<String> {
        let (map_m, plant_m) = (maps.table2.vehicle.wheelbase_m, plant.vehicle.wheelbase_m);
        if (map_m - plant_m).abs() > 0.01 * plant_m {
            return Some(format!(
                "not tested: the map's vehicle has a wheelbase of {map_m} m, the simulated one {plant_m} m; name the map's vehicle with --vehicle"
            ));
        }
        match &self.kind {
            ManoeuvreKind::Polyline { .. } | ManoeuvreKind::Planned(_) => None,
            ManoeuvreKind::Compensation(_) if maps.lateral.is_some() => None,
            ManoeuvreKind::Compensation(_) => {
                Some("not tested: there is no lateral_table.json; make one with pivot-cal lateral fit".to_owned())
            }
        }
    }

    /// The path that it should drive, for a log or a picture.
    ///
    /// # Errors
    /// Points that are not a path.
    pub fn reference(&self, wheelbase_m: f64) -> Result<PosePath> {
        match &self.kind {
            ManoeuvreKind::Polyline { points, settings, .. } => {
                let plan = PolylinePlan::new(points, settings)?;
                Ok(PosePath { poses: plan.legs.into_iter().flat_map(|leg| leg.poses).collect() })
            }
            ManoeuvreKind::Compensation(scenario) => Ok(scenario.path(wheelbase_m)),
            ManoeuvreKind::Planned(task) => Ok(task.plan(wheelbase_m)?.path),
        }
    }

    /// Its plan, if it is planned beforehand.
    pub(crate) fn plan(&self, wheelbase_m: f64) -> Result<Option<Planned>> {
        match &self.kind {
            ManoeuvreKind::Planned(task) => task.plan(wheelbase_m).map(Some),
            ManoeuvreKind::Polyline { .. } | ManoeuvreKind::Compensation(_) => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::manoeuvre::error::Error;
    use crate::sim::VehicleFile;
    use crate::verify::reference_maps::known_maps;
    use std::collections::BTreeSet;

    #[test]
    fn every_manoeuvre_has_a_name_of_its_own_that_no_pivot_has() {
        let all = Manoeuvre::all();
        let pivots = crate::verify::Scenario::all();
        let names: BTreeSet<&str> = all.iter().map(|m| m.name.as_str()).chain(pivots.iter().map(|s| s.name.as_str())).collect();
        assert_eq!(names.len(), all.len() + pivots.len());
        assert!(all.iter().all(|m| !m.class.is_pivot()));
    }

    #[test]
    fn points_replace_those_of_polylines_alone() {
        let given = [[0.0, 0.0], [5.0, 0.0], [5.0, 5.0]].map(PolylinePoint::from);
        for manoeuvre in Manoeuvre::all() {
            let along = manoeuvre.clone().along(&given).unwrap();
            match &along.kind {
                ManoeuvreKind::Polyline { points, .. } => {
                    assert_eq!(points, &given);
                    assert!(along.what.starts_with("2 given segments"), "{}", along.what);
                }
                _ => assert_eq!(along, manoeuvre),
            }
        }
        let error = Manoeuvre::all().remove(0).along(&given[..1]).unwrap_err();
        assert!(matches!(error, Error::Polyline(_)), "{error}");
    }

    #[test]
    fn a_map_of_another_vehicle_and_one_without_its_lateral_table_are_not_tested() {
        let vehicle = VehicleFile::bundled().unwrap().settings();
        let (table1, table2) = known_maps(&vehicle).unwrap();
        let maps = Maps::new(table1, table2).unwrap();
        let not_tested = |vehicle: &sim::WorldSettings| -> Vec<Class> {
            Manoeuvre::all().iter().filter(|m| m.reason_against(&maps, vehicle).is_some()).map(|m| m.class).collect()
        };
        assert_eq!(not_tested(&vehicle), [Class::Compensation; 4]);
        let mut longer = vehicle.clone();
        longer.vehicle.wheelbase_m *= 1.02;
        assert_eq!(not_tested(&longer).len(), Manoeuvre::all().len());
    }
}
