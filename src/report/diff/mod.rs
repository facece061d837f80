//! Two reports beside each other: what of the configuration differs, and which figures.

mod config;
mod figures;

use std::path::Path;

use serde::Serialize;

use super::error::ReportError;
use super::grid::Grid;
use super::numbers::read_numbers;
use super::writer::SUMMARY_FILE;

/// Two reports, and what differs between them.
#[derive(Serialize)]
pub(crate) struct Diff {
    /// Fields of the experiments as run: the path, and the value in each.
    config: Vec<[String; 3]>,
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

    /// How many figures differ.
    fn differing(&self) -> usize {
        self.figures.iter().filter(|figure| figure.differs()).count()
    }

    /// What was found, in a sentence.
    pub(crate) fn verdict(&self) -> String {
        let config = match self.config.len() {
            0 => "no field of the configuration".to_owned(),
            1 => "1 field of the configuration".to_owned(),
            count => format!("{count} fields of the configuration"),
        };
        format!("{config} and {} of {} figures differ", self.differing(), self.figures.len())
    }

    /// Both, without what is the same.
    pub(crate) fn grids(&self) -> impl Iterator<Item = Grid> {
        [self.config_grid(), self.figures_grid()].into_iter().filter(|grid| !grid.rows.is_empty())
    }

    /// The fields that differ.
    fn config_grid(&self) -> Grid {
        let head = ["configuration", "A", "B"].map(Into::into).to_vec();
        Grid { head, names: 3, rows: self.config.iter().map(|row| row.to_vec()).collect() }
    }

    /// The figures that differ, with the change from A to B.
    fn figures_grid(&self) -> Grid {
        let rows = self.figures.iter().filter(|figure| figure.differs()).map(figures::Figure::row);
        Grid { head: ["figure", "A", "B", "change"].map(Into::into).to_vec(), names: 1, rows: rows.collect() }
    }
}
