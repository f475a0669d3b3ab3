//! Recording: drives a campaign plan on the simulator and writes a log that any MCAP tool reads.
//!
//! In: a vehicle ([`crate::sim::VehicleFile`]) and a [`Campaign`]. Out: the bytes of an MCAP file of ROS 2 messages, and a
//! [`RecordReport`] of the runs. Other modules also use [`LogWriter`] and [`RosMessage`] to write ROS 2 logs.

mod campaign;
mod cdr;
mod error;
mod event;
mod log_writer;
mod message;
mod recorder;
mod runner;
mod schema;
mod topics;

pub(crate) use campaign::WheelAngles;
pub use campaign::{Campaign, RunGroup, Torques};
pub(crate) use error::{Error, Result};
pub(crate) use log_writer::LogWriter;
pub(crate) use message::{JointState, MessageStamp, Odometry, PathMessage, PointStamped, RosMessage};
pub use recorder::record;
