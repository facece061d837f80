//! What differs between two reports.

use std::path::Path;

use serde::Serialize;

use super::config;
use super::figures::{self, Figure};
use crate::report::error::ReportError;
use crate::report::format::signed;
use crate::report::grid::Grid;
use crate::report::numbers::read_numbers;
use crate::report::writer::SUMMARY_FILE;

/// Two reports, and what differs between them.
#[derive(Serialize)]
pub(crate) struct Diff {
    /// The reports' folders.
    pub(super) folders: [String; 2],
    /// Fields of the experiments that differ: the path, and the value in each.
    config: Vec<[String; 3]>,
    pub(super) figures: Vec<Figure>,
}

impl Diff {
    /// Compares the reports in two folders: all their numbers if `all` is set, otherwise the key figures of runs.
    ///
    /// # Errors
    /// A folder has no readable report.
    pub(crate) fn of(folders: [&Path; 2], all: bool) -> Result<Self, ReportError> {
        let [a, b] = folders.map(|folder| read_numbers(&folder.join(SUMMARY_FILE)));
        let [a, b] = [a?, b?];
        let [config_a, config_b] = folders.map(config::read);
        let config = config::differences(&config_a?, &config_b?);
        let folders = folders.map(|folder| folder.display().to_string());
        Ok(Self { folders, config, figures: figures::differences(&a, &b, all) })
    }

    /// Number of figures that differ.
    fn differing(&self) -> usize {
        self.figures.iter().filter(|figure| figure.differs()).count()
    }

    /// Summarizes the comparison in a sentence.
    pub(crate) fn verdict(&self) -> String {
        let config = match self.config.len() {
            0 => "no field of the configuration".to_owned(),
            1 => "1 field of the configuration".to_owned(),
            count => format!("{count} fields of the configuration"),
        };
        let most = finding(self).map(|most| format!("; {most}")).unwrap_or_default();
        format!("{config} and {} of {} figures differ{most}", self.differing(), self.figures.len())
    }

    /// The tables of fields and of figures that differ; an empty table is left out.
    pub(crate) fn grids(&self) -> impl Iterator<Item = Grid> {
        [self.config_grid(), self.figures_grid()].into_iter().filter(|grid| !grid.rows.is_empty())
    }

    /// The fields that differ.
    pub(super) fn config_grid(&self) -> Grid {
        let head = ["configuration", "A", "B"].map(Into::into).to_vec();
        Grid { head, names: 3, rows: self.config.iter().map(|row| row.to_vec()).collect() }
    }

    /// The figures that differ, with the change from A to B.
    pub(super) fn figures_grid(&self) -> Grid {
        let rows = self.figures.iter().filter(|figure| figure.differs()).map(Figure::row);
        Grid { head: ["figure", "A", "B", "change"].map(Into::into).to_vec(), names: 1, rows: rows.collect() }
    }
}

/// Figures that change, the largest change first; equal changes in the order of the report.
pub(super) fn changes(diff: &Diff) -> Vec<(&Figure, f64)> {
    let changes = diff.figures.iter().filter_map(|it| Some((it, it.change()?)));
    let mut changes: Vec<_> = changes.filter(|(_, change)| *change != 0.0).collect();
    changes.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    changes
}

/// The largest change, in a sentence.
fn finding(diff: &Diff) -> Option<String> {
    changes(diff).first().map(|(figure, change)| told(figure, *change))
}

pub(super) fn told(figure: &Figure, change: f64) -> String {
    format!("{} changes most, by {}", figure.name(), signed(change))
}
