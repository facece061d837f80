//! Reads the numbers of a report back.

use std::fs;
use std::path::Path;

use super::error::ReportError;
use super::replay::ReplaySummary;
use super::run::read_summary;
use super::sweep::SweepSummary;
use crate::json;

/// Reads the summary of a run, of a sweep or of a replay.
///
/// # Errors
/// The file cannot be read, or holds no summary of this version.
pub(crate) fn read_numbers(path: &Path) -> Result<serde_json::Value, ReportError> {
    let broken = |source| ReportError::Broken { path: path.into(), source };
    let text = fs::read(path).map_err(|source| ReportError::Read { path: path.into(), source })?;
    if let Ok(sweep) = json::read::<SweepSummary>(&text) {
        return json::value(&sweep).map_err(broken);
    }
    match json::read::<ReplaySummary>(&text) {
        Ok(replay) => json::value(&replay).map_err(broken),
        Err(_) => json::value(&read_summary(path)?).map_err(broken),
    }
}
