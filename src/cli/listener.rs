//! Shows the events of stages: lines on the terminal, progress as bars.

use crate::calibrate::StageEvent;
use crate::cli::Ui;
use indicatif::ProgressBar;
use std::sync::{Mutex, PoisonError};

/// Shows the events of a stage.
pub(crate) struct UiListener {
    ui: Ui,
    what: &'static str,
    bar: Mutex<Option<ProgressBar>>,
}

impl UiListener {
    /// `what` is shown beside a bar.
    pub(crate) fn new(ui: Ui, what: &'static str) -> Self {
        Self { ui, what, bar: Mutex::new(None) }
    }

    /// Shows an event.
    pub(crate) fn hear(&self, event: StageEvent) {
        match event {
            StageEvent::Warning(text) => self.ui.warn(text),
            StageEvent::Note(text) => self.ui.say(text),
            StageEvent::Detail(text) => self.ui.detail(text),
            StageEvent::Read { bytes, total } => self.count(bytes, total, |ui, what| ui.progress(0, what)),
            StageEvent::Simulated { total } => self.count(1, total as u64, Ui::progress_runs),
            StageEvent::Complete => {
                if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).take() {
                    bar.finish_and_clear();
                }
            }
        }
    }

    fn count(&self, more: u64, total: u64, new: impl FnOnce(Ui, &str) -> ProgressBar) {
        let mut bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        let bar = bar.get_or_insert_with(|| new(self.ui, self.what));
        bar.set_length(total);
        bar.inc(more);
    }
}
