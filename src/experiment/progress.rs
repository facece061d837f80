//! Progress on standard error: a bar on a terminal, a line every half minute elsewhere.

use std::io::{IsTerminal, stderr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressState, ProgressStyle};

use crate::console;

/// Time between lines where there is no terminal.
const EVERY: Duration = Duration::from_secs(30);
/// The remaining time is estimated after this time and a tenth of the work.
const STABLE: Duration = Duration::from_secs(3);

/// The progress of one piece of work. Dropping it removes the bar.
pub(super) struct Progress {
    bar: ProgressBar,
    lines: Option<(Arc<AtomicBool>, JoinHandle<()>)>,
}

impl Progress {
    /// A progress that shows nothing.
    #[cfg(test)]
    pub(super) fn hidden() -> Self {
        Self { bar: ProgressBar::hidden(), lines: None }
    }

    /// Counts `count` more things as done.
    pub(super) fn inc(&self, count: u64) {
        self.bar.inc(count);
    }

    /// Starts again from zero.
    pub(super) fn reset(&self) {
        self.bar.reset();
    }

    /// Names the current stage.
    pub(super) fn set_message(&self, message: &'static str) {
        self.bar.set_message(message);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
        if let Some((done, thread)) = self.lines.take() {
            done.store(true, Ordering::Relaxed);
            thread.thread().unpark();
            // The printing thread has no result to lose.
            let _ = thread.join();
        }
    }
}

/// The progress of `message` over `length` things, named in the plural.
pub(super) fn bar(message: &'static str, length: usize, things: &'static str) -> Progress {
    if console::is_quiet() {
        return Progress { bar: ProgressBar::hidden(), lines: None };
    }
    let template = format!("{{msg:>10}} [{{bar:24}}] {{pos}}/{{len}} {things}, {{elapsed}}{{rate}}{{left}}");
    let style = ProgressStyle::with_template(&template).expect("the template is right").progress_chars("=> ");
    // If the text cannot be written, the bar goes without it.
    let rate = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
        let _ = text.write_str(&rate(state.pos(), state.len().unwrap_or_default(), state.elapsed()));
    };
    let left = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
        let _ = text.write_str(&left(state.pos(), state.len().unwrap_or_default(), state.elapsed()));
    };
    let bar = ProgressBar::new(length as u64);
    bar.set_style(style.with_key("rate", rate).with_key("left", left));
    bar.set_message(message);
    bar.enable_steady_tick(Duration::from_millis(250));
    let lines = (!stderr().is_terminal()).then(|| lines(bar.clone(), things));
    Progress { bar, lines }
}

/// Writes a line every half minute until the work is done.
fn lines(bar: ProgressBar, things: &'static str) -> (Arc<AtomicBool>, JoinHandle<()>) {
    let done = Arc::new(AtomicBool::new(false));
    let is_done = Arc::clone(&done);
    let thread = std::thread::spawn(move || {
        let mut told = Duration::ZERO;
        while !is_done.load(Ordering::Relaxed) {
            let next = (told + EVERY).saturating_sub(bar.elapsed());
            if next.is_zero() {
                told += EVERY;
                let (at, of) = (bar.position(), bar.length().unwrap_or_default());
                let left = left(at, of, bar.elapsed());
                let message = bar.message();
                console::note(format!("{message}: {at} of {of} {things} after {} s{left}", told.as_secs()));
            } else {
                std::thread::park_timeout(next);
            }
        }
    });
    (done, thread)
}

fn is_stable(at: u64, of: u64, elapsed: Duration) -> bool {
    at < of && at >= 2 && at * 10 >= of && elapsed >= STABLE
}

/// A time in whole minutes, or in seconds where it is short.
fn about(left: Duration) -> String {
    let seconds = match left.as_secs() {
        short @ 0..120 => short.max(1),
        long => long.div_ceil(60) * 60,
    };
    format!(", about {} left", humantime::format_duration(Duration::from_secs(seconds)))
}

/// The mean rate since the start: things per second, or seconds per thing. The bar's own rate falls to nothing while
/// no thing ends.
fn rate(at: u64, of: u64, elapsed: Duration) -> String {
    let each = elapsed.as_secs_f64() / at as f64;
    match each {
        _ if at == 0 || at >= of || elapsed.is_zero() => String::new(),
        each if each <= 1.0 => format!(", {:.1}/s", 1.0 / each),
        each => format!(", {each:.1} s each"),
    }
}

/// The remaining time, if the remaining things take as long as those done.
fn left(at: u64, of: u64, elapsed: Duration) -> String {
    if !is_stable(at, of, elapsed) {
        return String::new();
    }
    about(elapsed.mul_f64((of - at) as f64 / at as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_is_made_when_there_is_something_to_go_by() {
        let seconds = Duration::from_secs;
        assert!(!is_stable(1, 4, seconds(100)), "one thing tells nothing");
        assert!(!is_stable(4, 100, seconds(100)), "too little of the whole");
        assert!(!is_stable(20, 100, seconds(1)), "too early");
        assert!(is_stable(20, 100, seconds(10)));
        assert!(!is_stable(100, 100, seconds(10)), "nothing is left");
        assert_eq!(about(seconds(90)), ", about 1m 30s left");
        assert_eq!(about(Duration::ZERO), ", about 1s left");
        // The estimate stays the same while nothing ends.
        assert_eq!(left(27, 45, seconds(600)), ", about 7m left");
        assert_eq!(left(1, 45, seconds(600)), "");
        assert_eq!([rate(3, 12, seconds(126)), rate(6, 12, seconds(3))], [", 42.0 s each", ", 2.0/s"]);
        assert_eq!([rate(0, 12, seconds(9)), rate(12, 12, seconds(9))], ["", ""]);
    }
}
