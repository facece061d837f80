//! Columns of policies, which both plots share.

use crate::report::draw::DrawError;
use crate::report::draw::canvas::{Canvas, LEFT, Text};
use crate::report::draw::palette::INK;

/// Where columns begin, right of the cases' names.
pub(super) fn first_column(canvas: &Canvas<'_>) -> i32 {
    if canvas.is_narrow() { 94 } else { 140 }
}

/// Height of the columns' names: three short lines.
pub(super) const HEAD: i32 = 3 * 15 + 8;
/// Height of a case's row.
pub(super) const ROW: i32 = 24;

/// Draws the columns' names, in lines that end above `bottom`; returns the columns' width.
pub(super) fn head(canvas: &Canvas<'_>, bottom: i32, names: &[&str]) -> Result<i32, DrawError> {
    let first = first_column(canvas);
    let width = ((canvas.width() - first - LEFT) / names.len().max(1) as i32).min(150);
    for (column, name) in (0..).zip(names) {
        let lines = lines(name);
        for (line, text) in (0..).zip(&lines) {
            let y = bottom - 12 - 15 * (lines.len() as i32 - 1 - line);
            canvas.text(&fitted(text, width), (first + column * width, y), Text::NOTE.colored(INK))?;
        }
    }
    Ok(width)
}

/// Cuts a word that would run into the next column.
fn fitted(word: &str, width: i32) -> String {
    if Text::NOTE.width(word) <= width {
        return word.to_owned();
    }
    let letters = word.chars().scan(String::new(), |text, letter| {
        text.push(letter);
        (Text::NOTE.width(text) <= width).then_some(letter)
    });
    letters.collect::<String>() + "."
}

/// Splits a name such as `OccluderGrid` or `all repairs` into lines of one word each.
pub(super) fn lines(name: &str) -> Vec<String> {
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
    fn words_are_cut_where_there_is_no_room() {
        assert_eq!(fitted("Published", 100), "Published");
        assert_eq!(fitted("Published", Text::NOTE.width("Publ")), "Publ.");
    }

    #[test]
    fn names_break_at_words() {
        assert_eq!(lines("OccluderGrid"), ["Occluder", "Grid"]);
        assert_eq!(lines("all repairs"), ["all", "repairs"]);
        assert_eq!(lines("Off"), ["Off"]);
    }
}
