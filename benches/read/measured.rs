//! Times of things that are compared, taken in turns.

use std::time::Instant;

/// What one thing took, turn by turn [s].
#[derive(Default)]
pub(crate) struct Taken {
    wall_s: Vec<f64>,
    cpu_s: Vec<f64>,
}

impl Taken {
    /// The shortest turn by the clock [s].
    pub(crate) fn best_s(&self) -> f64 {
        self.wall_s.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Processor time of this over that of `other`: the median over the turns. A busy machine disturbs it less than the clock.
    pub(crate) fn cpu_over(&self, other: &Self) -> f64 {
        let mut ratios: Vec<f64> = self.cpu_s.iter().zip(&other.cpu_s).map(|(this, other)| this / other).collect();
        ratios.sort_by(f64::total_cmp);
        ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// Each of `works` in turn, `rounds` times over.
pub(crate) fn in_turns<const N: usize>(rounds: usize, mut works: [&mut dyn FnMut() -> u64; N]) -> [Taken; N] {
    let mut taken = [(); N].map(|()| Taken::default());
    for _ in 0..rounds {
        for (work, taken) in works.iter_mut().zip(&mut taken) {
            let (cpu, start) = (cpu_s(), Instant::now());
            std::hint::black_box(work());
            taken.wall_s.push(start.elapsed().as_secs_f64());
            taken.cpu_s.push(cpu_s() - cpu);
        }
    }
    taken
}

/// Processor time of all threads of this process so far [s].
fn cpu_s() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return f64::NAN };
    let of = |path: std::path::PathBuf| std::fs::read_to_string(path.join("schedstat")).ok()?.split(' ').next()?.parse::<f64>().ok();
    threads.flatten().filter_map(|thread| of(thread.path())).sum::<f64>() * 1e-9
}

/// Says whether a figure reaches its goal.
pub(crate) fn verdict(reached: bool) -> &'static str {
    if reached { "reached" } else { "MISSED" }
}

/// The most memory that this process ever had [MB].
pub(crate) fn peak_memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<f64>().ok().map(|kilobytes| kilobytes / 1024.0)
}
