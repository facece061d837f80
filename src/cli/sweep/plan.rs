//! The file of `--plan`.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use serde_json::Value;

use crate::experiment::sweep::{Listed, Listing};
use crate::json;
use crate::output::OutputFile;

/// Writes the points, one per line.
pub(super) fn write(path: &Path, listing: &Listing) -> Result<()> {
    let is_json = path.extension().is_some_and(|kind| ["jsonl", "ndjson", "json"].iter().any(|known| kind == *known));
    let lines = if is_json { json_lines(listing)? } else { csv(listing)? };
    let put = || -> io::Result<()> {
        let mut file = OutputFile::create(path)?;
        file.write_all(&lines)?;
        file.finish()
    };
    put().with_context(|| format!("cannot write {}", path.display()))
}

fn json_lines(listing: &Listing) -> Result<Vec<u8>> {
    let mut lines = Vec::new();
    for point in &listing.points {
        lines.extend((json::line(point)? + "\n").bytes());
    }
    Ok(lines)
}

fn csv(listing: &Listing) -> Result<Vec<u8>> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let fields = listing.fields.iter().map(String::as_str);
    table.write_record(["index", "machine", "policy", "role"].into_iter().chain(fields).chain(["identity", "cost"]))?;
    for point in &listing.points {
        let Listed { index, machine, policy, role, fields, identity, cost } = point;
        let value = |path: &String| fields.get(path).map_or_else(String::new, text);
        let names = [index.to_string(), machine.clone(), policy.clone(), (*role).to_owned()];
        let rest = [identity.clone(), cost.to_string()];
        table.write_record(names.into_iter().chain(listing.fields.iter().map(value)).chain(rest))?;
    }
    Ok(table.into_inner()?)
}

/// A value as a cell: a name without quotes, all else as JSON.
fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
