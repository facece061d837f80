//! Writing a run's report, and redrawing it.

use std::path::PathBuf;

use serde::Serialize;

use super::files::{CONFIG_FILE, RunFiles};
use super::frames_csv::frames_csv;
use super::over_time;
use super::page::page;
use super::plots::{self, Section};
use crate::output::ResultsFolder;
use crate::report::csv_table::CsvTable;
use crate::report::draw::{DrawError, Drawing};
use crate::report::error::ReportError;
use crate::report::results;
use crate::report::writer::{Report, ReportFile, write};

impl Report for RunFiles {
    type Section = Section;

    fn numbers(&self) -> &impl Serialize {
        &self.summary
    }

    fn tables(&self) -> Vec<CsvTable> {
        let over_time = (!self.over_time.is_empty()).then(|| over_time::table(&self.over_time));
        std::iter::once(frames_csv(&self.summary)).chain(over_time).collect()
    }

    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        let config = (CONFIG_FILE.into(), self.config.clone().into_bytes());
        let pictures = self.pictures.iter().map(|(info, png)| (PathBuf::from(&info.file), png.clone()));
        let results = results::files(&self.summary)?;
        Ok(std::iter::once(config).chain(results).chain(pictures).collect())
    }

    fn plots(&self) -> Result<Vec<Drawing<Section>>, DrawError> {
        plots::draw(&self.summary, &self.over_time)
    }

    fn page(&self, plots: &[Drawing<Section>]) -> Result<Option<String>, minijinja::Error> {
        page(&self.summary, &self.config, plots, &self.pictures).map(Some)
    }
}

/// Redraws plots and page of the report in `folder` from its own files. The same files give the same bytes. Returns
/// the page's path.
///
/// # Errors
/// A file cannot be read, made or written.
pub(crate) fn redraw(folder: &ResultsFolder) -> Result<PathBuf, ReportError> {
    write(folder, &RunFiles::read(folder.path())?)
}
