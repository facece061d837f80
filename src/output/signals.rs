//! Ctrl-C, and the signals by which batch systems and closed terminals end a program.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use super::registry;
use crate::console;

/// Set by the first signal, where a command asked for it.
static STOP: OnceLock<Arc<AtomicBool>> = OnceLock::new();

/// Watches for INT, TERM and HUP from now on. A command that asked for a [`stop_flag`] is stopped by the first signal
/// and ended by the second; others are ended by the first. Temporary files are removed in any case, and the exit status
/// is 128 and the signal's number, as shells have it.
///
/// # Errors
/// The system does not allow to watch.
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
                    console::tell("stopping after this frame; once more to stop at once");
                }
                _ => registry::remove_all_and_exit(128 + signal),
            }
        }
    })?;
    Ok(())
}

/// Other systems end a program by themselves.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn watch() -> io::Result<()> {
    Ok(())
}

/// Whether whoever started the program had it ignore a signal, as `nohup` does with HUP.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

/// A flag that the first signal sets from now on: the command ends by itself at the next good place.
pub(crate) fn stop_flag() -> Arc<AtomicBool> {
    Arc::clone(STOP.get_or_init(Arc::default))
}
