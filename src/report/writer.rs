//! Writes reports of all kinds: makes their files and puts them in place.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::csv_table::CsvTable;
use super::draw::{DrawError, Drawing};
use super::error::ReportError;
use crate::output::{ResultsFolder, write_whole};

/// The file with all numbers; a directory that holds it is a report.
pub(crate) const SUMMARY_FILE: &str = "summary.json";
/// The name of the page's file.
const PAGE_FILE: &str = "index.html";
/// The folder of the plots.
const PLOTS_FOLDER: &str = "plots";

/// A file of a report: its path in the report's folder, and its bytes.
pub(super) type ReportFile = (PathBuf, Vec<u8>);

/// The content of a report.
pub(crate) trait Report {
    /// Sections of the page for plots.
    type Section;

    /// The content of [`SUMMARY_FILE`].
    fn numbers(&self) -> &impl Serialize;

    /// The tables.
    fn tables(&self) -> Vec<CsvTable>;

    /// Files other than numbers, tables, plots and page.
    ///
    /// # Errors
    /// A file cannot be made.
    fn attachments(&self) -> Result<Vec<ReportFile>, ReportError> {
        Ok(Vec::new())
    }

    /// The plots.
    ///
    /// # Errors
    /// A plot cannot be drawn.
    fn plots(&self) -> Result<Vec<Drawing<Self::Section>>, DrawError>;

    /// The page with the plots; `None` if the report has no page.
    ///
    /// # Errors
    /// The page's template does not fit its values.
    fn page(&self, plots: &[Drawing<Self::Section>]) -> Result<Option<String>, minijinja::Error>;
}

/// The files of a report, and the one to look at first.
struct Files {
    all: Vec<ReportFile>,
    first: PathBuf,
}

/// Draws plots and page from a report's numbers.
fn drawings(report: &impl Report) -> Result<Files, ReportError> {
    let plots = report.plots()?;
    let page = report.page(&plots)?;
    let file = |name: &str, end: &str| Path::new(PLOTS_FOLDER).join(format!("{name}.{end}"));
    let mut all: Vec<ReportFile> = Vec::new();
    for plot in plots {
        let data = CsvTable { file: "a plot's data", head: plot.data.head, rows: plot.data.rows };
        all.push((file(&plot.name, "csv"), data.bytes()?));
        all.push((file(&plot.name, "svg"), plot.file.into_bytes()));
    }
    all.extend(page.map(|page| (PAGE_FILE.into(), page.into_bytes())));
    let page_or_plot = all.last().map(|(path, _)| path.clone());
    Ok(Files { first: page_or_plot.unwrap_or_else(|| SUMMARY_FILE.into()), all })
}

fn files(report: &impl Report) -> Result<Files, ReportError> {
    let Files { all: drawn, first } = drawings(report)?;
    let mut all = report.attachments()?;
    all.push((SUMMARY_FILE.into(), json(SUMMARY_FILE, report.numbers())?));
    for table in report.tables() {
        all.push((table.file.into(), table.bytes()?));
    }
    all.extend(drawn);
    Ok(Files { all, first })
}

/// A JSON file's bytes.
///
/// # Errors
/// A value cannot be represented in JSON.
pub(super) fn json(file: &'static str, value: &impl Serialize) -> Result<Vec<u8>, ReportError> {
    let text = crate::json::pretty(value).map_err(|source| ReportError::Numbers { file, source })?;
    Ok((text + "\n").into_bytes())
}

/// Writes a report into `folder`, complete or not at all, and replaces an earlier one. Foreign files stay. Returns
/// the file to look at first.
///
/// # Errors
/// A file cannot be made, or a file or folder cannot be written.
pub(crate) fn write(folder: &ResultsFolder, report: &impl Report) -> Result<PathBuf, ReportError> {
    let Files { all, first } = files(report)?;
    folder.replace(|dir| {
        put_all(dir, &all).map_err(|error| match error {
            // The error names the file's final place, since the new directory is gone when the user reads it.
            ReportError::Write { path, source } => ReportError::Write {
                path: path.strip_prefix(dir).map_or(path.clone(), |file| folder.path().join(file)),
                source,
            },
            other => other,
        })
    })?;
    Ok(folder.path().join(first))
}

/// Writes files into `folder`, each whole, and creates their folders.
fn put_all(folder: &Path, files: &[ReportFile]) -> Result<(), ReportError> {
    files.iter().try_for_each(|(file, bytes)| {
        let path = folder.join(file);
        let failed = |source| ReportError::Write { path: path.clone(), source };
        let parent = path.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(failed)?;
        write_whole(&path, bytes).map_err(failed)
    })
}
