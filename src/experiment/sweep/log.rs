//! Shows the progress of a sweep: a bar on a terminal, and lines in a log elsewhere.

use std::io::{IsTerminal, stderr};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::super::progress::{self, Progress};
use crate::console::note;

/// The time between two lines of a log.
const INTERVAL: Duration = Duration::from_secs(30);
/// Points done and time passed before the remaining time is estimated.
const STABLE: (usize, Duration) = (3, Duration::from_secs(5));

/// The progress of one process's points.
pub(super) struct Log {
    /// The sweep, its identity and the shard.
    subject: String,
    points: usize,
    begin: Instant,
    bar: Option<Progress>,
    state: Mutex<State>,
}

struct State {
    done: usize,
    /// Costs of the points done by this process, and of those left.
    cost: [u64; 2],
    told: Instant,
}

impl Log {
    /// Starts the progress of `points` points. `left` holds the costs of those that are not kept yet.
    pub(super) fn new(subject: String, points: usize, left: &[u64]) -> Self {
        let is_terminal = stderr().is_terminal();
        let begin = Instant::now();
        let kept = points - left.len();
        if !is_terminal {
            note(format!("{subject}: {points} points, {kept} kept, {} to make", left.len()));
        }
        let bar = is_terminal.then(|| progress::bar("replaying", left.len(), "points"));
        let state = Mutex::new(State { done: kept, cost: [0, left.iter().sum()], told: begin });
        Self { subject, points, begin, bar, state }
    }

    /// Counts a point of this cost as done.
    pub(super) fn done(&self, cost: u64) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.done += 1;
        state.cost[0] += cost;
        state.cost[1] -= cost;
        match &self.bar {
            Some(bar) => bar.inc(1),
            None if state.told.elapsed() >= INTERVAL => {
                state.told = Instant::now();
                note(self.line(&state, self.begin.elapsed()));
            }
            None => {}
        }
    }

    /// Ends the progress: all points are done.
    pub(super) fn finish(self) {
        match self.bar {
            Some(bar) => drop(bar),
            None => {
                let took = humantime::format_duration(Duration::from_secs(self.begin.elapsed().as_secs()));
                note(format!("{}: all {} points done in {took}", self.subject, self.points));
            }
        }
    }

    /// A line of the log.
    fn line(&self, state: &State, elapsed: Duration) -> String {
        let share = 100 * state.done / self.points.max(1);
        let progress = format!("{}: {} of {} points done ({share} %)", self.subject, state.done, self.points);
        let [made, left] = state.cost;
        if state.done < STABLE.0 || elapsed < STABLE.1 || made == 0 {
            return progress;
        }
        let seconds = elapsed.as_secs_f64() * left as f64 / made as f64;
        let left = humantime::format_duration(Duration::from_secs(seconds.min(1e9).ceil() as u64));
        format!("{progress}, about {left} left")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_comes_once_it_is_stable() {
        let log = Log { bar: None, ..Log::new("sweep words 12ab34cd, shard 1/2".into(), 40, &[1; 30]) };
        let line = |done, cost, seconds| log.line(&State { done, cost, told: log.begin }, Duration::from_secs(seconds));
        assert_eq!(line(2, [2, 28], 60), "sweep words 12ab34cd, shard 1/2: 2 of 40 points done (5 %)");
        assert_eq!(line(20, [10, 20], 4), "sweep words 12ab34cd, shard 1/2: 20 of 40 points done (50 %)");
        let told = "sweep words 12ab34cd, shard 1/2: 20 of 40 points done (50 %), about 2m left";
        assert_eq!(line(20, [10, 20], 60), told);
    }
}
