//! The failure map, and wrong decisions of each case over its frames.

use plotters::style::RGBColor;

use super::canvas::{Canvas, DrawError, LEFT, LINE, TITLES, Text, WIDTH, legend_height, pale, palette, svg};
use crate::report::format::exact;
use crate::report::stress::{CaseSummary, FrameWrong, Outcome, StressSummary};

/// Where columns begin, right of the cases' names.
const COLUMNS: i32 = 140;
/// Height of the columns' names: three short lines.
const HEAD: i32 = 3 * 15 + 8;
/// Height of a case's row.
const ROW: i32 = 24;

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
pub fn map(summary: &StressSummary) -> Result<String, DrawError> {
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

/// Bars of wrong decisions, frame by frame, for the cases and policies that have any.
pub fn over_frames(summary: &StressSummary) -> Result<String, DrawError> {
    let fails = |frames: &[FrameWrong]| Outcome::of(frames) != Outcome::Right;
    let columns: Vec<_> = (0..summary.policies.len())
        .filter(|&column| summary.cases.iter().any(|case| fails(&case.policies[column])))
        .collect();
    let cases: Vec<&CaseSummary> =
        summary.cases.iter().filter(|case| case.policies.iter().any(|frames| fails(frames))).collect();
    let names: Vec<_> = columns.iter().map(|&column| summary.policies[column].name.as_str()).collect();
    let top = TITLES + HEAD;
    let row_height = 2 * ROW;
    svg(top + cases.len() as i32 * row_height + LINE, |canvas| {
        canvas.titles(
            "Wrong shadow decisions over the frames",
            "a bar a frame, those of a case on one scale; the number is the most in a frame",
        )?;
        let width = head(canvas, top, &names)?;
        for (row, case) in (0..).zip(&cases) {
            let bottom = top + (row + 1) * row_height - 6;
            canvas.text(&case.name, (LEFT, bottom - 14), Text::LABEL)?;
            let all = case.policies.iter().flatten().map(FrameWrong::wrong);
            let most = all.max().unwrap_or(0).max(1);
            for (place, &column) in (0..).zip(&columns) {
                let (left, frames) = (COLUMNS + place * width, &case.policies[column]);
                canvas.line(vec![(left, bottom), (left + width - 8, bottom)], palette::GRID, 1)?;
                let bar = (width - 8) / frames.len().max(1) as i32;
                for (frame, wrong) in (0..).zip(frames) {
                    if wrong.wrong() > 0 {
                        let height = (wrong.wrong() * 26).div_ceil(most) as i32;
                        let x = left + frame * bar;
                        canvas.rect((x, bottom - height), (x + bar - 1, bottom), palette::VERMILLION)?;
                    }
                }
                if let Outcome::Healed { worst, .. } | Outcome::Wrong { worst, .. } = Outcome::of(frames) {
                    canvas.text(&exact(worst), (left, bottom - 34), Text::NOTE)?;
                }
            }
        }
        Ok(())
    })
}

/// The columns' names, in lines that end above `bottom`; gives the columns' width.
fn head(canvas: &Canvas<'_>, bottom: i32, names: &[&str]) -> Result<i32, DrawError> {
    let width = ((WIDTH - COLUMNS - LEFT) / names.len().max(1) as i32).min(150);
    for (column, name) in (0..).zip(names) {
        let lines = lines(name);
        for (line, text) in (0..).zip(&lines) {
            let y = bottom - 12 - 15 * (lines.len() as i32 - 1 - line);
            canvas.text(text, (COLUMNS + column * width, y), Text::NOTE.colored(palette::INK))?;
        }
    }
    Ok(width)
}

/// A name such as `OccluderGrid` or `all repairs` in lines of a word each.
fn lines(name: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for letter in name.chars() {
        match lines.last_mut() {
            Some(line) if letter != ' ' && !letter.is_uppercase() => line.push(letter),
            _ => lines.push(letter.to_string()),
        }
    }
    lines.into_iter().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_break_at_words() {
        assert_eq!(lines("OccluderGrid"), ["Occluder", "Grid"]);
        assert_eq!(lines("all repairs"), ["all", "repairs"]);
        assert_eq!(lines("Off"), ["Off"]);
    }
}
