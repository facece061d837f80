//! The failure map: case by policy.

use plotters::style::RGBColor;

use super::columns::{COLUMNS, HEAD, ROW, head};
use super::data::{Outcome, StressSummary};
use super::section::Section;
use crate::report::draw::canvas::{LEFT, LINE, TITLES, Text, legend_height, pale, palette, svg};
use crate::report::draw::{DrawError, Plot};
use crate::report::format::exact;

pub(super) const PLOT: Plot<StressSummary, Section> =
    Plot { name: "failure-map", section: Section::Map, draw: |summary| draw(summary).map(Some) };

const LOOKS: [(&str, RGBColor); 3] = [
    ("never wrong", palette::GREEN),
    ("wrong for some frames, then healed", palette::YELLOW),
    ("wrong to the last frame", palette::VERMILLION),
];

fn look(outcome: Outcome) -> RGBColor {
    let (_, color) = LOOKS[match outcome {
        Outcome::Right => 0,
        Outcome::Healed { .. } => 1,
        Outcome::Wrong { .. } => 2,
    }];
    pale(color)
}

/// Case by policy: how each case ended, the most wrong decisions in a frame, and the frames with any.
fn draw(summary: &StressSummary) -> Result<String, DrawError> {
    let legend = LOOKS.map(|(name, color)| (name.to_owned(), pale(color)));
    let top = TITLES + legend_height(&legend) + HEAD;
    let names: Vec<_> = summary.policies.iter().map(|policy| policy.name.as_str()).collect();
    svg(top + summary.cases.len() as i32 * ROW + LINE, |canvas| {
        canvas.titles(
            "Failure map",
            "the most wrong shadow decisions in a frame, and (in brackets) the number of frames with any",
        )?;
        canvas.legend(TITLES, &legend)?;
        let width = head(canvas, top, &names)?;
        for (row, case) in (0..).zip(&summary.cases) {
            let y = top + row * ROW;
            canvas.text(&case.name, (LEFT, y + ROW / 2), Text::LABEL)?;
            for (column, frames) in (0..).zip(&case.policies) {
                let (left, outcome) = (COLUMNS + column * width, Outcome::of(frames));
                canvas.rect((left, y), (left + width - 2, y + ROW - 2), look(outcome))?;
                if let Outcome::Healed { frames, worst } | Outcome::Wrong { frames, worst } = outcome {
                    let text = format!("{} ({frames})", exact(worst));
                    canvas.text(&text, (left + width / 2, y + ROW / 2), Text::NOTE.colored(palette::INK).centered())?;
                }
            }
        }
        Ok(())
    })
}
