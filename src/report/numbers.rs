//! Reads the numbers of a report back.

use std::path::Path;

use serde_json::Value;

use super::error::ReportError;
use super::replay::ReplaySummary;
use super::run::read_summary;
use super::sweep::SweepSummary;
use crate::input::{self, MAX_REPORT_FILE_BYTES};
use crate::json;

/// Reads the summary of a run, of a sweep or of a replay.
///
/// # Errors
/// The file cannot be read, or holds no summary of this version.
pub(crate) fn read_numbers(path: &Path) -> Result<Value, ReportError> {
    let broken = |source| ReportError::Broken { path: path.into(), source };
    let text = input::read(path, MAX_REPORT_FILE_BYTES);
    let text = text.map_err(|source| ReportError::Read { path: path.into(), source })?;
    let found: Value = json::read(&text).map_err(broken)?;
    // Only sweeps have points, and only replays have neither these nor the number of a schema.
    if found.get("points").is_some() {
        return json::value(&json::read::<SweepSummary>(&text).map_err(broken)?).map_err(broken);
    }
    if found.get("schema").is_none() && found.get("machines").is_some() {
        return json::value(&json::read::<ReplaySummary>(&text).map_err(broken)?).map_err(broken);
    }
    json::value(&read_summary(path)?).map_err(broken)
}
