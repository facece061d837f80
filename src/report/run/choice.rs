//! The decisions of `Auto` on streams, in one line.

use crate::report::format::{counted, percent};
use crate::stats::{Choice, MachineStats, Why};

/// The line for the streams of one machine; `None` if `Auto` replayed none of them.
pub(crate) fn choice<'a>(runs: impl IntoIterator<Item = &'a MachineStats>) -> Option<String> {
    let runs: Vec<_> = runs.into_iter().filter_map(|stats| Some((stats, stats.choice?))).collect();
    let of = |why: Why| runs.iter().filter(move |(_, choice)| choice.why == why);
    let sampled: Vec<_> = of(Why::Sampled).collect();
    let told = (!sampled.is_empty()).then(|| {
        let sum = |of: fn(&Choice) -> f64| sampled.iter().map(|(_, choice)| of(choice)).sum::<f64>();
        let widest = sampled.iter().filter_map(|(stats, _)| stats.accuracy.widest()).fold(0.0, f64::max);
        format!(
            "{} of {} by Event, \u{b1}{}; about {:.1} times less processor time than Event",
            sum(|choice| choice.windows as f64),
            counted(sum(|choice| choice.of as f64) as usize, "window"),
            percent(widest),
            sampled.len() as f64 / sum(|choice| choice.cost),
        )
    });
    let whole = [
        (Why::Short, "the stream is too short to sample"),
        (Why::Varied, "its windows differ too much for a sample to pay"),
    ];
    let whole = whole.into_iter().filter_map(|(why, because)| {
        let some = of(why).count();
        let whose = if some < runs.len() { format!(" on {}", counted(some, "stream")) } else { String::new() };
        (some > 0).then(|| format!("all by Event{whose}: {because}"))
    });
    let parts: Vec<String> = told.into_iter().chain(whole).collect();
    (!parts.is_empty()).then(|| format!("Auto: {}", parts.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::Accuracy;

    fn run(why: Why, windows: u64, cost: f64) -> MachineStats {
        let accuracy = Accuracy::Estimated { cycles: 0.012, l2_bytes: 0.007, dram_bytes: 0.0, rate: 0.05 };
        let choice = Some(Choice { target: 0.02, windows, of: 480, cost, why });
        MachineStats { choice, accuracy, ..MachineStats::default() }
    }

    #[test]
    fn one_line_says_what_was_done() {
        let (sampled, short) = (run(Why::Sampled, 24, 0.11), run(Why::Short, 0, 1.0));
        let line = |runs: &[&MachineStats]| choice(runs.iter().copied()).unwrap();
        assert_eq!(
            line(&[&sampled]),
            "Auto: 24 of 480 windows by Event, \u{b1}1.2 %; about 9.1 times less processor time than Event"
        );
        assert_eq!(line(&[&short]), "Auto: all by Event: the stream is too short to sample");
        assert_eq!(
            line(&[&run(Why::Varied, 24, 1.3)]),
            "Auto: all by Event: its windows differ too much for a sample to pay"
        );
        assert_eq!(
            line(&[&sampled, &short, &sampled]),
            "Auto: 48 of 960 windows by Event, \u{b1}1.2 %; about 9.1 times less processor time than Event; all by \
             Event on 1 stream: the stream is too short to sample"
        );
        assert_eq!(choice([&MachineStats::default()]), None);
    }
}
