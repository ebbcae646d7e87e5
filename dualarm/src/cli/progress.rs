//! Progress bars on standard error; none if it is not a terminal.

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// All bars of a command.
pub struct Progress {
    bars: MultiProgress,
}

impl Progress {
    /// Bars that are only drawn on a terminal, and never when `quiet`.
    pub fn new(quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        Self { bars: MultiProgress::with_draw_target(target) }
    }

    /// A bar that counts to `length`.
    pub fn bar(&self, title: &str, length: u64) -> ProgressBar {
        let bar = self.bars.add(ProgressBar::new(length));
        let style = ProgressStyle::with_template("{prefix:<22} {bar:36.cyan/dim} {percent:>3} %  {eta}");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()).progress_chars("━━─"));
        bar.set_prefix(title.to_owned());
        bar
    }
}
