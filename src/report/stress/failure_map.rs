//! The failure map: cases by policies.

use super::columns::{HEAD, ROW, first_column, head};
use super::data::{CaseSummary, Outcome, StressSummary};
use super::section::Section;
use crate::report::draw::canvas::{LEFT, LINE, Text};
use crate::report::draw::palette::{Color, GREEN, INK, VERMILLION, YELLOW, pale};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{counted, exact};
use crate::report::grid::Grid;

pub(super) const PLOT: Plot<StressSummary, Section> =
    Plot { name: "failure-map", section: Section::Map, figure: |summary| Some(figure(summary)) };

const LOOKS: [(&str, Color); 3] =
    [("never wrong", GREEN), ("wrong for some frames, then healed", YELLOW), ("wrong to the last frame", VERMILLION)];

pub(super) fn look(outcome: Outcome) -> Color {
    let (_, color) = LOOKS[match outcome {
        Outcome::Right => 0,
        Outcome::Healed { .. } => 1,
        Outcome::Wrong { .. } => 2,
    }];
    pale(color)
}

/// The outcome of a case, in short.
pub(super) fn text(outcome: Outcome) -> String {
    match outcome {
        Outcome::Right => "0".into(),
        Outcome::Healed { frames, worst } | Outcome::Wrong { frames, worst } => format!("{} ({frames})", exact(worst)),
    }
}

/// Cases by policies: the outcome, the most wrong decisions in a frame, and the number of frames with any.
fn figure(summary: &StressSummary) -> Figure<'_> {
    let row = |case: &CaseSummary| -> Vec<String> {
        let outcomes = case.policies.iter().map(|frames| text(Outcome::of(frames)));
        std::iter::once(case.name.clone()).chain(outcomes).collect()
    };
    let names = || summary.policies.iter().map(|policy| policy.name.clone());
    Figure {
        title: verdict(summary),
        about: "The most wrong shadow decisions in a frame, and (in brackets) the number of frames with any.".into(),
        key: key(),
        data: Grid {
            head: std::iter::once("case".to_owned()).chain(names()).collect(),
            names: 1,
            rows: summary.cases.iter().map(row).collect(),
        },
        narrow: false,
        height: Box::new(|_| HEAD + summary.cases.len() as i32 * ROW + LINE),
        paint: Box::new(move |canvas| {
            let names: Vec<_> = summary.policies.iter().map(|policy| policy.name.as_str()).collect();
            let width = head(canvas, HEAD, &names)?;
            for (row, case) in (0..).zip(&summary.cases) {
                let y = HEAD + row * ROW;
                canvas.text(&case.name, (LEFT, y + ROW / 2), Text::LABEL)?;
                for (column, frames) in (0..).zip(&case.policies) {
                    let (left, outcome) = (first_column(canvas) + column * width, Outcome::of(frames));
                    canvas.rect((left, y), (left + width - 2, y + ROW - 2), look(outcome))?;
                    if outcome != Outcome::Right {
                        let at = (left + width / 2, y + ROW / 2);
                        canvas.text(&text(outcome), at, Text::NOTE.colored(INK).centered())?;
                    }
                }
            }
            Ok(())
        }),
    }
}

/// The colours of outcomes.
pub(super) fn key() -> Vec<(String, Color)> {
    LOOKS.map(|(name, color)| (name.to_owned(), pale(color))).into()
}

/// The policies' results over all cases, in a sentence.
pub(super) fn verdict(summary: &StressSummary) -> String {
    let (exact, others): (Vec<_>, Vec<_>) = (0..summary.policies.len()).partition(|&at| summary.policies[at].exact);
    let fails = |at: usize| {
        let frames = summary.cases.iter().map(|case| Outcome::of(&case.policies[at]));
        frames.filter(|outcome| *outcome != Outcome::Right).count()
    };
    let wrong: Vec<&str> =
        exact.iter().filter(|&&at| fails(at) > 0).map(|&at| summary.policies[at].name.as_str()).collect();
    let cases = counted(summary.cases.len(), "case");
    let of_exact = match wrong.as_slice() {
        [] => format!("{} made no wrong decision in {cases}", counted_policies(exact.len())),
        wrong => format!("{} must never be wrong, and are", wrong.join(", ")),
    };
    let worst = others.iter().max_by_key(|&&at| fails(at)).filter(|&&at| fails(at) > 0);
    let of_worst = worst.map(|&at| format!("; {} fails in {}", summary.policies[at].name, fails(at)));
    format!("{of_exact}{}", of_worst.unwrap_or_default())
}

fn counted_policies(count: usize) -> String {
    match count {
        1 => "The one exact policy".into(),
        count => format!("All {count} exact policies"),
    }
}
