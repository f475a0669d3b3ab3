//! Recording: a campaign plan driven on the simulator and written as a log that any MCAP tool reads.
//!
//! In: a vehicle ([`crate::sim::VehicleFile`]) and a [`Campaign`]. Out: the bytes of an MCAP file of ROS 2 messages, and a [`RecordReport`] of the
//! runs. [`LogWriter`] and [`RosMessage`] write ROS 2 logs for others too.

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

pub use campaign::{Campaign, RunGroup, RunPlan, TopicSettings, Torques, WheelAngles};
pub use error::{Error, Result};
pub use event::{EventKind, RunEvent};
pub use log_writer::LogWriter;
pub use message::{JointState, MessageStamp, Odometry, PathMessage, PointStamped, RosMessage, TwistStamped};
pub use recorder::{DrivenLog, RecordReport, record};
pub use runner::{End, RunOutcome};
