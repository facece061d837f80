//! What `Auto` did with a stream, in one line.

use crate::report::format::{counted, percent, short};
use crate::stats::{Choice, MachineStats, Why};

/// The line; none of a run that `Auto` did not make.
pub(crate) fn choice(stats: &MachineStats) -> Option<String> {
    let Choice { target, windows, of, cost, why } = stats.choice?;
    let within = stats.accuracy.widest().unwrap_or_default();
    Some(match why {
        Why::Sampled => format!(
            "Auto: {windows} of {} by Event, \u{b1}{} ({} was asked for); about {} times less processor time than \
             Event on everything",
            counted(of as usize, "window"),
            percent(within),
            percent(target),
            short((1.0 / cost * 10.0).round() / 10.0),
        ),
        Why::Short => format!(
            "Auto: all by Event: the stream is too short to sample to \u{b1}{} ({})",
            percent(target),
            counted(of as usize, "window")
        ),
        Why::Varied => format!(
            "Auto: all by Event: after {windows} of {}, a sample to \u{b1}{} would have taken longer",
            counted(of as usize, "window"),
            percent(target)
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Accuracy;

    #[test]
    fn one_line_says_what_was_done() {
        let line = |why, windows, cost, accuracy| {
            let choice = Some(Choice { target: 0.02, windows, of: 480, cost, why });
            choice_of(MachineStats { choice, accuracy, ..MachineStats::default() })
        };
        let sampled = Accuracy::Estimated { cycles: 0.012, l2_bytes: 0.007, dram_bytes: 0.0, rate: 0.05 };
        assert_eq!(
            line(Why::Sampled, 24, 0.11, sampled),
            "Auto: 24 of 480 windows by Event, \u{b1}1.2 % (2.0 % was asked for); about 9.1 times less processor time \
             than Event on everything"
        );
        assert_eq!(
            line(Why::Short, 0, 1.0, Accuracy::Exact),
            "Auto: all by Event: the stream is too short to sample to \u{b1}2.0 % (480 windows)"
        );
        assert_eq!(
            line(Why::Varied, 24, 1.3, Accuracy::Exact),
            "Auto: all by Event: after 24 of 480 windows, a sample to \u{b1}2.0 % would have taken longer"
        );
        assert_eq!(choice(&MachineStats::default()), None);
    }

    fn choice_of(stats: MachineStats) -> String {
        choice(&stats).unwrap()
    }
}
