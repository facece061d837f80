//! Handles Ctrl-C, and the signals by which batch systems and closed terminals end a program.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use super::registry;

/// Set by the first signal, if a command asked for the flag.
static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Watches for INT, TERM and HUP from now on. For a command with a [`stop_flag`], the first signal stops it and the
/// second ends it; other commands end at the first. Temporary files are removed in any case. The exit status is 128
/// plus the signal's number, as in shells.
///
/// # Errors
/// The system refuses to install the handlers.
#[cfg(unix)]
pub(crate) fn watch() -> io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut wanted = vec![SIGINT, SIGTERM];
    if !is_ignored(SIGHUP) {
        wanted.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(wanted)?;
    std::thread::Builder::new().name("signals".into()).spawn(move || {
        for signal in signals.forever() {
            match STOP.get() {
                Some(stop) if !stop.swap(true, Ordering::Relaxed) => {
                    // A standard error that is full or closed loses it.
                    _ = writeln!(io::stderr(), "stopping after this frame; once more to stop at once");
                }
                _ => registry::remove_all_and_exit(128 + signal),
            }
        }
    })?;
    Ok(())
}

/// Does nothing: other systems end a program by themselves.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn watch() -> io::Result<()> {
    Ok(())
}

/// Whether the program was started with a signal ignored, as `nohup` does with HUP.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// A flag that the first signal sets: the command then ends by itself at the next safe point.
pub(crate) fn stop_flag() -> Arc<AtomicBool> {
    Arc::clone(STOP.get_or_init(Arc::default))
}
