//! The thread that fuzzes is the pool: no time is lost handing work to another one.

/// To be called before the first input.
pub fn init() {
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
}
