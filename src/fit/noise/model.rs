//! The random part of the model: a disturbance, an offset per stretch, noise in every reading.
//!
//! State [v, d, b]: v̇ = d + b. v is the part of the speed that the surface does not explain, d an Ornstein-Uhlenbeck acceleration
//! (standard deviation σ_d, time constant τ_d), and b a constant acceleration of the stretch (σ_b). v jumps a little where a step of the
//! torque comes early or late (`drive::step_timing`). A reading is v plus white noise.

/// The random part of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Noise {
    /// σ_d [m/s²].
    pub(crate) disturbance_mps2: f64,
    /// τ_d [s].
    pub(crate) disturbance_time_s: f64,
    /// σ_b [m/s²].
    pub(crate) offset_mps2: f64,
    /// Standard deviation of a reading of each speed source [m/s]: encoder, yaw rate.
    pub(crate) reading_mps: [f64; 2],
    /// Standard deviation of the speed where a stretch starts from rest, over its prior
    /// ([`Segment::start_std`](crate::fit::motion::segment::Segment)).
    pub(crate) start_scale: f64,
}

impl Noise {
    /// 1/σ² of a reading of each speed source [s²/m²].
    pub(crate) fn precisions(&self) -> [f64; 2] {
        self.reading_mps.map(|std| 1.0 / (std * std))
    }
}

/// Prior standard deviation of the speed where a stretch does not start from rest [m/s].
pub(crate) const UNKNOWN_SPEED_MPS: f64 = 3.0;

/// One reading in a stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reading {
    /// Time on the reference clock [s].
    pub(crate) t_s: f64,
    /// Speed in the gear's frame, scale and bias removed [m/s].
    pub(crate) speed_mps: f64,
    /// 0 encoder, 1 yaw rate; of several readings, that of the first.
    pub(crate) source: u8,
    /// Index of the sample in its source's series; of several, of the first.
    pub(crate) sample: u32,
    /// How many readings of each source it is the mean of.
    pub(crate) of: [u8; 2],
    /// Variance that the uncertain time of steps adds to the speed since the reading before [m²/s²].
    pub(crate) shaken_mps_2: f64,
    /// Its own variance [m²/s²], where it replaces a reading in coarse steps (`noise::quantisation`); 0 for that of its source.
    pub(crate) own_variance_mps_2: f64,
}

impl Reading {
    /// One reading of one source.
    pub(crate) fn single(t_s: f64, speed_mps: f64, source: u8, sample: u32) -> Self {
        let of = if source == 0 { [1, 0] } else { [0, 1] };
        Self { t_s, speed_mps, source, sample, of, shaken_mps_2: 0.0, own_variance_mps_2: 0.0 }
    }

    /// Its variance [m²/s²], given 1/σ² of a reading of each speed source.
    pub(crate) fn variance(&self, precisions: [f64; 2]) -> f64 {
        if self.own_variance_mps_2 > 0.0 {
            return self.own_variance_mps_2;
        }
        1.0 / (f64::from(self.of[0]) * precisions[0] + f64::from(self.of[1]) * precisions[1])
    }
}
