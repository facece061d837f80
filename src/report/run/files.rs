//! The files of a run's report, in memory and read back.

use std::path::{Component, Path};

use super::over_time::{self, OverTime};
use super::pictures::{Image, PictureInfo, png};
use super::summary::{SCHEMA, Summary};
use crate::input::{self, MAX_CONFIG_BYTES, MAX_REPORT_FILE_BYTES};
use crate::json;
use crate::report::error::ReportError;
use crate::report::writer::SUMMARY_FILE;

/// The experiment as run.
pub(super) const CONFIG_FILE: &str = "config.ron";

/// A picture and its PNG file.
pub(super) type PngPicture = (PictureInfo, Vec<u8>);

/// The content of a run's report.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RunFiles {
    /// The numbers.
    pub summary: Summary,
    /// The experiment as run, in RON.
    pub config: String,
    /// The pictures, in the page's order.
    pub pictures: Vec<PngPicture>,
    /// What machines did over time; only machines replayed by `Event` or `Cycle` are recorded.
    pub over_time: OverTime,
}

impl RunFiles {
    /// The files of a run with these numbers and pictures; the summary lists the pictures.
    ///
    /// # Errors
    /// A picture cannot be encoded.
    pub(crate) fn new(
        mut summary: Summary,
        config: String,
        pictures: &[(PictureInfo, Image)],
    ) -> Result<Self, ReportError> {
        summary.pictures = pictures.iter().map(|(info, _)| info.clone()).collect();
        let encode = |(info, image): &(PictureInfo, Image)| -> Result<PngPicture, ReportError> {
            let bytes = png(image).map_err(|source| ReportError::Picture { file: info.file.clone(), source })?;
            Ok((info.clone(), bytes))
        };
        let pictures = pictures.iter().map(encode).collect::<Result<_, _>>()?;
        Ok(Self { summary, config, pictures, over_time: OverTime::new() })
    }

    /// Reads the files of the report in `folder`.
    ///
    /// # Errors
    /// A file cannot be read, the summary is not of this version, or it names a picture outside the report.
    pub(crate) fn read(folder: &Path) -> Result<Self, ReportError> {
        let path = folder.join(SUMMARY_FILE);
        let summary = read_summary(&path)?;
        let config = folder.join(CONFIG_FILE);
        let config =
            input::read_text(&config, MAX_CONFIG_BYTES).map_err(|source| ReportError::Read { path: config, source })?;
        let mut pictures = Vec::new();
        for info in &summary.pictures {
            let inside = Path::new(&info.file).components().all(|part| matches!(part, Component::Normal(_)));
            if !inside {
                return Err(ReportError::Outside { path, file: info.file.clone() });
            }
            let picture = folder.join(&info.file);
            let png = input::read(&picture, MAX_REPORT_FILE_BYTES)
                .map_err(|source| ReportError::Read { path: picture, source })?;
            pictures.push((info.clone(), png));
        }
        Ok(Self { summary, config, pictures, over_time: over_time::read(folder)? })
    }
}

/// Reads a run's summary.
///
/// # Errors
/// The file cannot be read, or holds no summary of this version.
pub(crate) fn read_summary(path: &Path) -> Result<Summary, ReportError> {
    let broken = |source| ReportError::Broken { path: path.into(), source };
    let read = input::read(path, MAX_REPORT_FILE_BYTES);
    let text = read.map_err(|source| ReportError::Read { path: path.into(), source })?;
    let value: serde_json::Value = json::read(&text).map_err(broken)?;
    match value.get("schema") {
        Some(found) if *found != SCHEMA => {
            Err(ReportError::Schema { path: path.into(), found: found.to_string(), schema: SCHEMA })
        }
        _ => json::read(&text).map_err(broken),
    }
}
