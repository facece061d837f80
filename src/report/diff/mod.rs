//! Two reports beside each other: what of the configuration differs, and which figures.

mod config;
mod figures;

use std::path::Path;

use super::error::ReportError;
use super::grid::Grid;
use super::numbers::read_numbers;
use super::writer::SUMMARY_FILE;

/// Two reports, and what differs between them.
pub(crate) struct Diff {
    /// Fields of the experiments as run: the path, and the value in each.
    pub config: Vec<[String; 3]>,
    figures: Vec<figures::Figure>,
}

impl Diff {
    /// Compares the reports in two folders; all their numbers if `all` is set, and the key figures of runs otherwise.
    ///
    /// # Errors
    /// A folder has no report that can be read.
    pub(crate) fn of(folders: [&Path; 2], all: bool) -> Result<Self, ReportError> {
        let [a, b] = folders.map(|folder| read_numbers(&folder.join(SUMMARY_FILE)));
        let [a, b] = [a?, b?];
        let [config_a, config_b] = folders.map(config::read);
        Ok(Self { config: config::differences(&config_a?, &config_b?), figures: figures::differences(&a, &b, all) })
    }

    /// How many figures both reports have or one of them alone has.
    pub(crate) fn compared(&self) -> usize {
        self.figures.len()
    }

    /// How many of them differ.
    pub(crate) fn differing(&self) -> usize {
        self.figures.iter().filter(|figure| figure.differs()).count()
    }

    /// The fields that differ.
    pub(crate) fn config_grid(&self) -> Grid {
        let head = ["configuration", "A", "B"].map(Into::into).to_vec();
        Grid { head, names: 3, rows: self.config.iter().map(|row| row.to_vec()).collect() }
    }

    /// The figures that differ, with the change from A to B.
    pub(crate) fn figures_grid(&self) -> Grid {
        let rows = self.figures.iter().filter(|figure| figure.differs()).map(figures::Figure::row);
        Grid { head: ["figure", "A", "B", "change"].map(Into::into).to_vec(), names: 1, rows: rows.collect() }
    }
}
