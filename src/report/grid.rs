//! Tables of texts, and their layout in a terminal.

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table};

use super::terminal;

/// A table of texts: names, then numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    /// Headers.
    pub head: Vec<String>,
    /// Number of columns that are names; they come first.
    pub names: usize,
    /// Rows, each as long as `head`.
    pub rows: Vec<Vec<String>>,
}

/// A table style with a line under the header alone.
const PLAIN: &str = "     ──            ";
/// A table style without lines.
const BARE: &str = "                   ";
/// Number of letters between two columns.
const GAP: usize = 2;

/// A table at most as wide as the terminal, without a final line break.
pub(crate) fn drawn(grid: &Grid) -> String {
    fitted(grid, terminal::width())
}

/// A table that loses its last columns, but not the first `needed`, if the terminal is too narrow for all.
pub(crate) fn drawn_most(grid: &Grid, needed: usize) -> String {
    let width = terminal::width();
    let fits = |columns: &usize| fitted(&first(grid, *columns), width).lines().all(|line| !line.is_empty());
    let columns = (needed + 1..=grid.head.len()).rev().find(fits).unwrap_or(needed);
    fitted(&first(grid, columns), width)
}

/// The first columns of a grid.
fn first(grid: &Grid, columns: usize) -> Grid {
    let of = |row: &Vec<String>| row.iter().take(columns).cloned().collect();
    Grid { head: of(&grid.head), names: grid.names, rows: grid.rows.iter().map(of).collect() }
}

/// A table of at most `width` letters per line, if its columns allow it. Headers are broken into several lines;
/// columns that do not fit follow in further tables, which repeat the names.
fn fitted(grid: &Grid, width: usize) -> String {
    let cells: Vec<usize> = (0..grid.head.len())
        .map(|column| grid.rows.iter().map(|row| letters(&row[column])).max().unwrap_or_default())
        .collect();
    let whole: Vec<usize> = cells.iter().zip(&grid.head).map(|(cells, head)| letters(head).max(*cells)).collect();
    if total(&whole) <= width {
        return table(&grid.head, grid, &(0..grid.head.len()).collect::<Vec<_>>(), width);
    }
    let head: Vec<String> = grid.head.iter().zip(&cells).map(|(head, cells)| wrapped(head, *cells)).collect();
    let narrow: Vec<usize> = cells.iter().zip(&head).map(|(cells, head)| letters(head).max(*cells)).collect();
    let names: Vec<usize> = (0..grid.names.min(grid.head.len())).collect();
    let mut parts = vec![names.clone()];
    for column in grid.names..grid.head.len() {
        let part = parts.last_mut().expect("there is a part");
        let is_full = part.len() > names.len()
            && total(&part.iter().chain([&column]).map(|&at| narrow[at]).collect::<Vec<_>>()) > width;
        if is_full {
            parts.push(names.iter().copied().chain([column]).collect());
        } else {
            part.push(column);
        }
    }
    parts.iter().map(|part| table(&head, grid, part, width)).collect::<Vec<_>>().join("\n\n")
}

fn total(widths: &[usize]) -> usize {
    widths.iter().sum::<usize>() + GAP * widths.len().saturating_sub(1)
}

/// The widest line of a text.
fn letters(text: &str) -> usize {
    text.lines().map(|line| line.chars().count()).max().unwrap_or_default()
}

/// A header in lines no longer than `width` or its longest word.
fn wrapped(head: &str, width: usize) -> String {
    let width = head.split(' ').map(letters).max().unwrap_or_default().max(width);
    let mut lines: Vec<String> = Vec::new();
    for word in head.split(' ') {
        match lines.last_mut() {
            Some(line) if letters(line) + 1 + letters(word) <= width => *line += &format!(" {word}"),
            _ => lines.push(word.into()),
        }
    }
    lines.join("\n")
}

/// The columns `columns` of a grid, at most `width` letters per line.
fn table(head: &[String], grid: &Grid, columns: &[usize], width: usize) -> String {
    let row = |row: &[String]| columns.iter().map(|&column| row[column].clone()).collect::<Vec<_>>();
    let mut table = Table::new();
    table.load_preset(PLAIN).set_header(row(head));
    for cells in &grid.rows {
        table.add_row(row(cells));
    }
    // Names alone may be too wide: they are broken over lines, and columns of single words are kept whole if there is
    // room.
    if table.lines().any(|line| letters(&line) > width) {
        table.set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(u16::try_from(width).unwrap_or(u16::MAX));
        let word = |&at: &usize| grid.rows.iter().flat_map(|row| row[at].split_whitespace()).map(letters).max();
        let words: Vec<usize> = columns.iter().map(|at| word(at).unwrap_or_default()).collect();
        if total(&words) <= width {
            let cells = |at: usize| grid.rows.iter().map(|row| letters(&row[at])).max().unwrap_or_default();
            let places = table.column_iter_mut().zip(columns.iter().zip(words));
            for (column, _) in places.filter(|(_, (at, word))| cells(**at) == *word) {
                column.set_constraint(ColumnConstraint::ContentWidth);
            }
        }
    }
    for (place, (column, &at)) in table.column_iter_mut().zip(columns).enumerate() {
        column.set_padding((0, u16::from(place + 1 < columns.len())));
        if at >= grid.names {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table.trim_fmt()
}

/// A text broken at the terminal's width.
pub(crate) fn paragraph(text: &str) -> String {
    let mut table = Table::new();
    table.load_preset(BARE).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(u16::try_from(terminal::width()).unwrap_or(u16::MAX)).add_row([text]);
    for column in table.column_iter_mut() {
        column.set_padding((0, 0));
    }
    table.trim_fmt()
}

/// Names with their meanings beside them, at the terminal's width, without a final line break.
pub(crate) fn definitions(rows: &[(String, String)]) -> String {
    let mut table = Table::new();
    table.load_preset(BARE).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(u16::try_from(terminal::width()).unwrap_or(u16::MAX));
    for (name, meaning) in rows {
        table.add_row([name, meaning]);
    }
    if let Some(names) = table.column_mut(0) {
        names.set_constraint(comfy_table::ColumnConstraint::ContentWidth);
    }
    table.trim_fmt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        let row = |name: &str| [name, "31.7 %", "1,234", "52.1 %"].map(Into::into).to_vec();
        Grid {
            head: ["policy", "nodes saved", "tests/pixel", "triangles saved"].map(Into::into).to_vec(),
            names: 1,
            rows: vec![row("Off"), row("Published")],
        }
    }

    #[test]
    fn a_name_stays_whole_where_a_text_beside_it_can_be_broken() {
        let name = "machines.*.policies.*.frames.*.dram.row_hits";
        let row = [name, "commands", "column commands that found their row open"].map(Into::into).to_vec();
        let head = ["statistic", "unit", "what it is"].map(Into::into).to_vec();
        let told = fitted(&Grid { head, names: 3, rows: vec![row] }, 80);
        assert!(told.contains(name) && told.lines().all(|line| letters(line) <= 80), "{told}");
    }

    #[test]
    fn a_table_fits_by_its_headers_first_and_goes_on_below_then() {
        insta::assert_snapshot!(fitted(&grid(), 80), @r"
        policy     nodes saved  tests/pixel  triangles saved
        ────────────────────────────────────────────────────
        Off             31.7 %        1,234           52.1 %
        Published       31.7 %        1,234           52.1 %
        ");
        insta::assert_snapshot!(fitted(&grid(), 44), @r"
        policy      nodes  tests/pixel  triangles
                    saved                   saved
        ─────────────────────────────────────────
        Off        31.7 %        1,234     52.1 %
        Published  31.7 %        1,234     52.1 %
        ");
        insta::assert_snapshot!(fitted(&grid(), 30), @r"
        policy      nodes  tests/pixel
                    saved
        ──────────────────────────────
        Off        31.7 %        1,234
        Published  31.7 %        1,234

        policy     triangles
                       saved
        ────────────────────
        Off           52.1 %
        Published     52.1 %
        ");
        for width in 24..60 {
            assert!(fitted(&grid(), width).lines().all(|line| line.chars().count() <= width), "{width}");
        }
    }
}
