//! Writes reports: whatever a report is of, its files are made and put into their places here.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::csv_table::CsvTable;
use super::draw::{DrawError, Drawing};
use super::error::ReportError;
use crate::output::write_whole;

/// The file with all numbers; a directory that holds it is a report.
pub(crate) const SUMMARY_FILE: &str = "summary.json";
/// The page.
const PAGE_FILE: &str = "index.html";
/// The folder of the plots.
const PLOTS_FOLDER: &str = "plots";

/// A file of a report: its path in the report's folder, and its bytes.
pub(super) type ReportFile = (PathBuf, Vec<u8>);

/// What a report is made of.
pub(crate) trait Report {
    /// Sections of the page that plots belong to.
    type Section;

    /// What [`SUMMARY_FILE`] holds.
    fn numbers(&self) -> &impl Serialize;

    /// The tables.
    fn tables(&self) -> Vec<CsvTable>;

    /// Files beside numbers, tables, plots and page.
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

    /// The page, which holds the plots; none if the report has no page.
    ///
    /// # Errors
    /// The page's template does not fit its values.
    fn page(&self, plots: &[Drawing<Self::Section>]) -> Result<Option<String>, minijinja::Error>;
}

/// The files of a report, and which of them to look at first.
struct Files {
    all: Vec<ReportFile>,
    first: PathBuf,
}

/// What is drawn from a report's numbers: plots and page.
fn drawings(report: &impl Report) -> Result<Files, ReportError> {
    let plots = report.plots()?;
    let page = report.page(&plots)?;
    let file = |name: &str| Path::new(PLOTS_FOLDER).join(format!("{name}.svg"));
    let mut all: Vec<ReportFile> = plots.into_iter().map(|plot| (file(&plot.name), plot.svg.into_bytes())).collect();
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
/// A value has no form in JSON.
pub(super) fn json(file: &'static str, value: &impl Serialize) -> Result<Vec<u8>, ReportError> {
    let mut text = serde_json::to_vec_pretty(value).map_err(|source| ReportError::Numbers { file, source })?;
    text.push(b'\n');
    Ok(text)
}

/// Writes a report at `target`, in the place of an earlier one if there is one. The report is made in a directory
/// beside
/// `target` and comes into its place complete or not at all: after an error the place is unchanged. Returns the file to
/// look at first.
///
/// # Errors
/// The target is no report's place, a file cannot be made, or a file or folder cannot be written.
pub(crate) fn write(target: &Path, report: &impl Report) -> Result<PathBuf, ReportError> {
    let Files { all, first } = files(report)?;
    replace(target, |dir| put_all(dir, &all))?;
    Ok(target.join(first))
}

/// Writes a report's files into `folder`, each whole, beside what else lies there. Returns the file to look at first.
///
/// # Errors
/// A file cannot be made or written.
pub(crate) fn update(folder: &Path, report: &impl Report) -> Result<PathBuf, ReportError> {
    let Files { all, first } = files(report)?;
    put_all(folder, &all)?;
    Ok(folder.join(first))
}

/// Draws the plots and the page of the report in `folder` again. Each file is replaced whole, and none before all are
/// drawn. Returns the file to look at first.
///
/// # Errors
/// A file cannot be made or written.
pub(super) fn draw_again(folder: &Path, report: &impl Report) -> Result<PathBuf, ReportError> {
    let Files { all, first } = drawings(report)?;
    put_all(folder, &all)?;
    Ok(folder.join(first))
}

/// Whether a report can be written at `target`: there is nothing, an empty directory, or an earlier report. To be asked
/// before a long run.
///
/// # Errors
/// Something that is no report is in the way, or the folder cannot be read.
pub(crate) fn check_target(target: &Path) -> Result<(), ReportError> {
    let foreign = || ReportError::Foreign { path: target.into() };
    match fs::read_dir(target) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        Err(error) if error.kind() == io::ErrorKind::NotADirectory => Err(foreign()),
        Err(source) => Err(ReportError::Read { path: target.into(), source }),
        Ok(mut entries) => {
            if entries.next().is_none() {
                return Ok(());
            }
            // Any version of a summary will do, but a summary it must be.
            let text = fs::read(target.join(SUMMARY_FILE)).map_err(|_| foreign())?;
            let summary: serde_json::Value = serde_json::from_slice(&text).map_err(|_| foreign())?;
            summary.get("schema").and(summary.get("policies")).map(|_| ()).ok_or_else(foreign)
        }
    }
}

/// Puts what `fill` makes in a new directory at `target`, complete or not at all.
fn replace(target: &Path, fill: impl FnOnce(&Path) -> Result<(), ReportError>) -> Result<(), ReportError> {
    check_target(target)?;
    let parent = match target.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(|source| ReportError::Write { path: parent.into(), source })?;
    let beside = tempfile::Builder::new()
        .prefix(".umbrasim-report-")
        .tempdir_in(parent)
        .map_err(|source| ReportError::Write { path: parent.into(), source })?;

    // The directory beside is private to the user; the one in it has the rights that directories usually get.
    let staging = beside.path().join("new");
    fill(&staging).map_err(|error| match error {
        // The place that the file was meant for: the one beside it is gone when the user reads this.
        ReportError::Write { path, source } => ReportError::Write {
            path: path.strip_prefix(&staging).map_or(path.clone(), |file| target.join(file)),
            source,
        },
        other => other,
    })?;
    let earlier = beside.path().join("earlier");
    let in_the_way = match fs::rename(target, &earlier) {
        Ok(()) => true,
        Err(error) if error.kind() == io::ErrorKind::NotFound => false,
        Err(source) => return Err(ReportError::Write { path: target.into(), source }),
    };
    fs::rename(&staging, target).map_err(|source| {
        if in_the_way {
            // The first error is the one to tell; the earlier report goes back if it can.
            let _ = fs::rename(&earlier, target);
        }
        ReportError::Write { path: target.into(), source }
    })
}

/// Writes files into `folder`, each whole, with the folders that they lie in.
fn put_all(folder: &Path, files: &[ReportFile]) -> Result<(), ReportError> {
    files.iter().try_for_each(|(file, bytes)| {
        let path = folder.join(file);
        let failed = |source| ReportError::Write { path: path.clone(), source };
        let parent = path.parent().unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(failed)?;
        write_whole(&path, bytes).map_err(failed)
    })
}
