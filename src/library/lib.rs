//! A controller in a shared library: opened, checked for its version, and called once per control period.
//!
//! This is the only unsafe code of pivot-cal. Code of the library's author runs in this process: what it does to memory is theirs, and a library
//! that crashes or never returns ends or holds the program. A controller that is not trusted so far is judged as a process.

use libloading::{Library, Symbol};
use std::ffi::{OsStr, c_int, c_uint, c_void};
use std::fmt;
use std::ptr::NonNull;

/// Presets of a turn, as `pivot_presets` of `pivot_controller.h`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct LibraryPresets {
    /// 0 hold-left, 1 mirror.
    pub policy: c_int,
    /// Wheel angle of turns to the right with mirror [rad].
    pub right_angle_rad: f64,
    /// Wheel angle after a turn [rad].
    pub return_angle_rad: f64,
}

/// Middle of the rear axle, as `pivot_pose`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LibraryPose {
    /// East [m].
    pub x_m: f64,
    /// North [m].
    pub y_m: f64,
    /// Heading [rad].
    pub heading_rad: f64,
}

/// Readings of a control period, as `pivot_inputs`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LibraryInputs {
    /// 0 when the reading is lost.
    pub has_speed: c_int,
    /// Front-wheel speed [m/s], vehicle frame.
    pub speed_mps: f64,
    /// Wheel angle [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Pose.
    pub pose: LibraryPose,
    /// 1 forward, −1 reverse, 0 neutral.
    pub gear: c_int,
    /// Whether the emergency stop is active.
    pub emergency_stop: c_int,
}

/// Commands of a control period, as `pivot_outputs`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct LibraryOutputs {
    /// Torque [N·m], vehicle frame.
    pub torque_nm: f64,
    /// Target of the wheel [rad].
    pub wheel_angle_rad: f64,
    /// 1 forward, −1 reverse, 0 neutral.
    pub gear: c_int,
    /// Number of the phase.
    pub phase: c_int,
    /// Number of the failure.
    pub failure: c_int,
    /// Whether the wheel returns.
    pub restore: c_int,
    /// Whether what follows is that of a period of the drive law.
    pub has_drive: c_int,
    /// Desired speed [m/s], gear frame.
    pub target_speed_mps: f64,
    /// Speed of the look-up [m/s], gear frame.
    pub drive_speed_mps: f64,
    /// Desired acceleration [m/s²], gear frame.
    pub accel_mps2: f64,
    /// Place on the arc [m].
    pub arc_m: f64,
    /// Whether the desired acceleration was limited.
    pub limited: c_int,
    /// Whether the look-up was outside the table.
    pub outside_table: c_int,
    /// Whether the end is reached.
    pub end_reached: c_int,
}

/// Version of functions and structs: those of this crate. The sizes tell a library that was built for others.
pub const ABI: u32 = 1 << 24 | (size_of::<LibraryInputs>() as u32) << 12 | size_of::<LibraryOutputs>() as u32;

/// Why a library cannot be used.
#[derive(Debug)]
#[non_exhaustive]
pub enum Error {
    /// It cannot be opened, or a function is missing; the text is that of the system.
    Open(libloading::Error),
    /// It was built for other functions or structs.
    Abi {
        /// What the library says.
        found: u32,
    },
    /// It made no controller with these presets.
    NoController,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(error) => {
                let mut cause: &dyn std::error::Error = error;
                while let Some(deeper) = cause.source() {
                    cause = deeper;
                }
                write!(f, "{cause}; a library needs the five functions of pivot_controller_library.c (export --format controller-c)")
            }
            Self::Abi { found } => write!(
                f,
                "it is built for version {found:#x} of the functions and structs; needed: {ABI:#x}: build it again with the files that export --format \
                 controller-c writes"
            ),
            Self::NoController => f.write_str("pivot_library_create returned none; the presets may be out of its range"),
        }
    }
}

impl std::error::Error for Error {}

type CreateFn = unsafe extern "C" fn(*const LibraryPresets) -> *mut c_void;
type DestroyFn = unsafe extern "C" fn(*mut c_void);
type RequestFn = unsafe extern "C" fn(*mut c_void, f64, *const LibraryPose) -> c_int;
type StepFn = unsafe extern "C" fn(*mut c_void, *const LibraryInputs, *mut LibraryOutputs);

/// One controller of a library.
#[derive(Debug)]
pub struct LibraryController {
    handle: NonNull<c_void>,
    destroy: DestroyFn,
    request: RequestFn,
    step: StepFn,
    /// Last: what the pointers point into is closed after the controller is destroyed.
    _library: Library,
}

impl LibraryController {
    /// Opens a library, checks its version, and makes a controller. Opening it again for another controller costs some microseconds.
    ///
    /// # Errors
    /// It cannot be opened, lacks a function, is of another version, or makes no controller.
    pub fn open(path: &OsStr, presets: &LibraryPresets) -> Result<Self, Error> {
        // SAFETY: initialisers of the library run; the user named the file as the controller to be run
        let library = unsafe { Library::new(path) }.map_err(Error::Open)?;
        // SAFETY: the template declares `unsigned pivot_library_abi(void)`
        let abi: Symbol<'_, unsafe extern "C" fn() -> c_uint> = unsafe { library.get("pivot_library_abi") }.map_err(Error::Open)?;
        // SAFETY: the function takes nothing and returns a number
        let found = unsafe { abi() };
        if found != ABI {
            return Err(Error::Abi { found });
        }
        // SAFETY: for this version the template declares it with these types
        let create: CreateFn = *unsafe { library.get("pivot_library_create") }.map_err(Error::Open)?;
        // SAFETY: as above
        let destroy: DestroyFn = *unsafe { library.get("pivot_library_destroy") }.map_err(Error::Open)?;
        // SAFETY: as above
        let request: RequestFn = *unsafe { library.get("pivot_library_request") }.map_err(Error::Open)?;
        // SAFETY: as above
        let step: StepFn = *unsafe { library.get("pivot_library_step") }.map_err(Error::Open)?;
        // SAFETY: the presets live until it returns
        let handle = NonNull::new(unsafe { create(presets) }).ok_or(Error::NoController)?;
        Ok(Self { handle, destroy, request, step, _library: library })
    }

    /// Requests a turn [rad], left positive; 0 if it is accepted.
    pub fn request(&mut self, turn_rad: f64, pose: &LibraryPose) -> i32 {
        // SAFETY: the controller is alive and used by this thread alone, the pose lives until it returns
        unsafe { (self.request)(self.handle.as_ptr(), turn_rad, pose) }
    }

    /// The commands of a control period.
    pub fn step(&mut self, inputs: &LibraryInputs) -> LibraryOutputs {
        let mut outputs = LibraryOutputs::default();
        // SAFETY: the controller is alive and used by this thread alone, both structs live until it returns
        unsafe { (self.step)(self.handle.as_ptr(), inputs, &raw mut outputs) };
        outputs
    }
}

impl Drop for LibraryController {
    fn drop(&mut self) {
        // SAFETY: it was made by the library's create, is destroyed once, and the library is still open
        unsafe { (self.destroy)(self.handle.as_ptr()) };
    }
}
