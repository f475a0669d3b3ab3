//! Routes of manoeuvres: polylines with turns on the spot, the laws that track a path of poses, and the speed along it.
//!
//! Unlike the pivot's own files these allocate: they plan, and their laws run, on a computer.

pub mod clothoid_path;
pub mod follower;
pub mod front_axle;
pub mod lqr;
pub mod mpc;
pub mod path_position;
pub mod polyline;
pub mod polyline_driver;
pub mod pure_pursuit;
pub mod rear_axle;
pub mod segment_speed;
pub mod track;
pub mod tracking;
pub mod turn_law;
