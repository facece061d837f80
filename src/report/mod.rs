//! Reports: what a run found, as numbers (`summary.json`, `frames.csv`), plots, pictures and a page that shows all.
//!
//! This side sees statistics and pictures as data, never what made them.

pub mod chart;
pub mod explain;
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
mod steady;
pub mod stress;
pub mod summary;
pub mod sweep;
mod table;
mod template;

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

pub use crate::named::Named;
use crate::output::write_whole;
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
    /// Something that is no report is in the way.
    #[error("{} is not an umbrasim report (it has no {SUMMARY_FILE} of one) and will not be overwritten", path.display())]
    Foreign {
        /// What is in the way.
        path: PathBuf,
    },
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
    #[error("{}: the picture `{file}` is not inside the report", path.display())]
    Outside {
        /// The summary.
        path: PathBuf,
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

/// Whether a report can be written at `target`: there is nothing, an empty directory, or an earlier report. To be asked
/// before a long run.
pub fn check_target(target: &Path) -> Result<(), ReportError> {
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

/// Writes a report at `target`, in the place of an earlier one if there is one. It is made in a directory beside it and
/// comes into its place complete or not at all: after an error the place is as it was.
pub fn write_report(target: &Path, report: &Report) -> Result<(), ReportError> {
    replace(target, |dir| fill(dir, report))
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
    redraw(dir)
}

/// Draws the plots and the page of the report in `dir` again from the files that lie there. The same files give the
/// same bytes. Each file is replaced whole, and none before all are drawn.
pub fn redraw(dir: &Path) -> Result<(), ReportError> {
    let path = dir.join(SUMMARY_FILE);
    let summary = read_summary(&path)?;
    let config = dir.join(CONFIG_FILE);
    let text = fs::read_to_string(&config).map_err(|source| ReportError::Read { path: config, source })?;
    let mut pictures = Vec::new();
    for info in &summary.pictures {
        let inside = Path::new(&info.file).components().all(|part| matches!(part, Component::Normal(_)));
        if !inside {
            return Err(ReportError::Outside { path, file: info.file.clone() });
        }
        let picture = dir.join(&info.file);
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
    let text = fs::read(path).map_err(|source| ReportError::Read { path: path.into(), source })?;
    let value: serde_json::Value = serde_json::from_slice(&text).map_err(broken)?;
    match value.get("schema") {
        Some(found) if *found != SCHEMA => Err(ReportError::Schema { path: path.into(), found: found.to_string() }),
        _ => serde_json::from_slice(&text).map_err(broken),
    }
}

/// Reads what the summary of a run or of a sweep holds.
pub fn read_numbers(path: &Path) -> Result<serde_json::Value, ReportError> {
    let broken = |source| ReportError::Broken { path: path.into(), source };
    let text = fs::read(path).map_err(|source| ReportError::Read { path: path.into(), source })?;
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
