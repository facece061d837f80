//! Progress bars on standard error; nothing where that is no terminal.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `length` frames.
pub fn frames(length: usize) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg:>10} [{bar:32}] {pos}/{len} frames, {per_sec}, {eta} left")
        .expect("the template is right")
        .progress_chars("=> ");
    let bar = ProgressBar::new(length as u64).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(250));
    bar
}
