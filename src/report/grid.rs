//! Tables of texts, and how a terminal shows them.

use comfy_table::{CellAlignment, Table};

/// A table of texts: names, then numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    /// Headers.
    pub head: Vec<String>,
    /// How many of the columns are names.
    pub names: usize,
    /// Rows, each as long as `head`.
    pub rows: Vec<Vec<String>>,
}

/// Nothing but a line under the header.
const PLAIN: &str = "     ──            ";

/// A table for the terminal, without a line's end at the end.
pub(crate) fn drawn(grid: &Grid) -> String {
    let mut table = Table::new();
    table.load_preset(PLAIN).set_header(&grid.head).add_rows(&grid.rows);
    for column in table.column_iter_mut().skip(grid.names) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table.trim_fmt()
}
