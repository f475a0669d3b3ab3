//! Routes of manoeuvres: polylines with turns on the spot, the laws that track a path of poses, and the speed along it.
//!
//! Unlike the pivot's own files these allocate: they plan, and their laws run, on a computer.

pub(crate) mod clothoid_path;
pub(crate) mod follower;
pub(crate) mod front_axle;
pub(crate) mod leg_speed;
pub(crate) mod lqr;
pub(crate) mod mpc;
pub(crate) mod path_position;
pub(crate) mod polyline;
pub(crate) mod polyline_driver;
pub(crate) mod pure_pursuit;
pub(crate) mod rear_axle;
pub(crate) mod response;
pub(crate) mod segment_speed;
pub(crate) mod track;
pub(crate) mod tracking;
pub(crate) mod turn_law;
