//! Reports: what a run found, as numbers (`summary.json`, `frames.csv`), plots, pictures and a page that shows all.
//!
//! This side sees statistics and pictures as data, never what made them.

pub mod chart;
pub mod explain;
pub mod file_names;
mod findings;
pub mod format;
pub mod ladder_map;
mod page;
pub mod pareto;
pub mod pictures;
pub mod plots;
pub mod reuse;
pub mod rung;
pub mod split;
pub mod stress;
pub mod summary;
pub mod sweep;
mod table;
mod template;

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use crate::input;
pub use crate::named::Named;
use crate::output::{FolderError, ResultsFolder, write_whole};
pub use table::{Grid, drawn, replayed, terminal};

use pictures::{Image, PictureInfo};
use summary::{SCHEMA, Summary};

/// The file with all numbers; a directory that holds it is a report.
pub const SUMMARY_FILE: &str = "summary.json";
/// The file with all counts, frame by frame.
pub const FRAMES_FILE: &str = "frames.csv";
/// The experiment as run.
pub const CONFIG_FILE: &str = "config.ron";
/// The page.
pub const PAGE_FILE: &str = "index.html";
/// The largest summary that is read, in bytes.
const MAX_SUMMARY_BYTES: u64 = 1 << 28;
/// The folder of the plots.
pub const PLOTS_FOLDER: &str = "plots";

/// Why a report cannot be written or drawn.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A file or folder cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The folder cannot be used.
    #[error(transparent)]
    Folder(#[from] FolderError),
    /// The file is no summary.
    #[error("{} is not a summary of a run", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: serde_json::Error,
    },
    /// The summary is of another version.
    #[error("{} has schema {found}; this version reads schema {SCHEMA}: run the experiment again", path.display())]
    Schema {
        /// The file.
        path: PathBuf,
        /// Its version, as it stands there.
        found: String,
    },
    /// The summary names a picture outside the report.
    #[error("the picture `{file}`, which {SUMMARY_FILE} names, is not inside the report")]
    Outside {
        /// The picture's path.
        file: String,
    },
    /// A picture cannot be made.
    #[error("cannot make the picture {file}")]
    Picture {
        /// Its file.
        file: String,
        /// What is wrong with it.
        source: png::EncodingError,
    },
    /// The summary cannot be put in words.
    #[error("cannot make {SUMMARY_FILE}")]
    Summary(#[source] serde_json::Error),
    /// The table cannot be made.
    #[error("cannot make {FRAMES_FILE}")]
    Table(#[source] csv::Error),
    /// A plot cannot be made.
    #[error("cannot make the plots")]
    Plot(#[source] plots::DrawError),
    /// The page cannot be made.
    #[error("cannot make {PAGE_FILE}")]
    Page(#[source] minijinja::Error),
}

/// A report before it is written.
#[derive(Clone, Debug)]
pub struct Report {
    /// The numbers. [`Summary::pictures`] is filled in from `pictures`.
    pub summary: Summary,
    /// The experiment as run, in RON.
    pub config: String,
    /// The pictures, in the page's order.
    pub pictures: Vec<(PictureInfo, Image)>,
}

/// Writes a report into the folder, in the place of an earlier one if there is one: complete or not at all.
///
/// # Errors
/// A part of the report cannot be made or written.
pub fn write_report(folder: &ResultsFolder, report: &Report) -> Result<(), ReportError> {
    replace(folder, |dir| fill(dir, report))
}

/// Puts what `fill` makes in a new directory into the folder, complete or not at all.
fn replace(folder: &ResultsFolder, fill: impl FnOnce(&Path) -> Result<(), ReportError>) -> Result<(), ReportError> {
    folder.replace(|dir| {
        fill(dir).map_err(|error| match error {
            // The place that the file was meant for: the new directory is gone when the user reads this.
            ReportError::Write { path, source } => ReportError::Write {
                path: path.strip_prefix(dir).map_or(path.clone(), |file| folder.path().join(file)),
                source,
            },
            other => other,
        })
    })
}

/// Writes all files of a report into the new directory `dir`.
fn fill(dir: &Path, report: &Report) -> Result<(), ReportError> {
    let mut summary = report.summary.clone();
    summary.pictures = report.pictures.iter().map(|(info, _)| info.clone()).collect();
    let mut text = serde_json::to_vec_pretty(&summary).map_err(ReportError::Summary)?;
    text.push(b'\n');
    put(&dir.join(CONFIG_FILE), report.config.as_bytes())?;
    put(&dir.join(FRAMES_FILE), &table::frames_csv(&summary).map_err(ReportError::Table)?)?;
    for (info, image) in &report.pictures {
        let png = pictures::png(image).map_err(|source| ReportError::Picture { file: info.file.clone(), source })?;
        put(&dir.join(&info.file), &png)?;
    }
    put(&dir.join(SUMMARY_FILE), &text)?;
    // What is drawn comes from the files, so that it can be drawn again.
    draw(dir)
}

/// Draws the plots and the page of a report again from its other files. The same files give the same bytes.
///
/// # Errors
/// A file of the report is missing or wrong, or the new ones cannot be written.
pub fn redraw(folder: &ResultsFolder) -> Result<(), ReportError> {
    replace(folder, |dir| {
        let summary = read_summary(&folder.path().join(SUMMARY_FILE))?;
        let numbers = [SUMMARY_FILE, CONFIG_FILE, FRAMES_FILE].into_iter().map(PathBuf::from);
        for file in numbers.chain(inside(&summary)?) {
            let from = folder.path().join(&file);
            let bytes = fs::read(&from).map_err(|source| ReportError::Read { path: from, source })?;
            put(&dir.join(file), &bytes)?;
        }
        draw(dir)
    })
}

/// The files of a summary's pictures.
fn inside(summary: &Summary) -> Result<Vec<PathBuf>, ReportError> {
    let file = |info: &PictureInfo| {
        let path = PathBuf::from(&info.file);
        let is_inside = path.components().all(|part| matches!(part, Component::Normal(_)));
        if is_inside { Ok(path) } else { Err(ReportError::Outside { file: info.file.clone() }) }
    };
    summary.pictures.iter().map(file).collect()
}

/// Draws the plots and the page of the report in `dir` from the files that lie there.
fn draw(dir: &Path) -> Result<(), ReportError> {
    let path = dir.join(SUMMARY_FILE);
    let summary = read_summary(&path)?;
    let config = dir.join(CONFIG_FILE);
    let text = fs::read_to_string(&config).map_err(|source| ReportError::Read { path: config, source })?;
    let mut pictures = Vec::new();
    for (info, file) in summary.pictures.iter().zip(inside(&summary)?) {
        let picture = dir.join(file);
        let png = fs::read(&picture).map_err(|source| ReportError::Read { path: picture, source })?;
        pictures.push((info, png));
    }
    let drawings = plots::draw(&summary).map_err(ReportError::Plot)?;
    let page = page::page(&summary, &text, &drawings, &pictures).map_err(ReportError::Page)?;
    for drawing in &drawings {
        put(&dir.join(PLOTS_FOLDER).join(format!("{}.svg", drawing.name)), drawing.svg.as_bytes())?;
    }
    put(&dir.join(PAGE_FILE), page.as_bytes())
}

/// Reads a summary of this version.
pub fn read_summary(path: &Path) -> Result<Summary, ReportError> {
    let broken = |source| ReportError::Broken { path: path.into(), source };
    let read = input::read(path, MAX_SUMMARY_BYTES);
    let text = read.map_err(|source| ReportError::Read { path: path.into(), source })?;
    let value: serde_json::Value = serde_json::from_slice(&text).map_err(broken)?;
    match value.get("schema") {
        Some(found) if *found != SCHEMA => Err(ReportError::Schema { path: path.into(), found: found.to_string() }),
        _ => serde_json::from_slice(&text).map_err(broken),
    }
}

/// Reads what the summary of a run or of a sweep holds.
pub fn read_numbers(path: &Path) -> Result<serde_json::Value, ReportError> {
    let broken = |source| ReportError::Broken { path: path.into(), source };
    let text =
        input::read(path, MAX_SUMMARY_BYTES).map_err(|source| ReportError::Read { path: path.into(), source })?;
    match serde_json::from_slice::<sweep::SweepSummary>(&text) {
        Ok(sweep) => serde_json::to_value(sweep).map_err(broken),
        Err(_) => serde_json::to_value(read_summary(path)?).map_err(broken),
    }
}

/// Writes a file whole, with the folders that it lies in.
fn put(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    let failed = |source| ReportError::Write { path: path.into(), source };
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(failed)?;
    write_whole(path, bytes).map_err(failed)
}

#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;
