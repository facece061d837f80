//! Merges folders of shards.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::error::SweepError;
use super::places::Places;
use super::plan::{Plan, Point};
use super::points::{self, Refused};
use super::shard::Shard;
use crate::console;

/// Copies into `own` the points of the plan that only `others` have.
///
/// # Errors
/// A point is in none of the folders, was made by another build of the program, or cannot be copied. `command` gives
/// the command that makes a shard in a folder.
pub(super) fn collect(
    plan: &Plan,
    own: &Path,
    others: &[PathBuf],
    command: impl Fn(Shard, &Path) -> String,
) -> Result<(), SweepError> {
    let mut missing = Vec::new();
    let mut foreign: Option<(PathBuf, String)> = None;
    let mut of_other_builds = 0;
    for point in &plan.points {
        let mut found = false;
        let mut refused = None;
        for folder in std::iter::once(own).chain(others.iter().map(PathBuf::as_path)) {
            let folder = Places::of(folder).points;
            let file = point.key.file(&folder);
            match points::read(&folder, point.key) {
                Ok(Some(measured)) => {
                    let target = Places::of(own).points;
                    if folder != target {
                        let failed = |source| SweepError::File { path: point.key.file(&target), source };
                        points::write(&target, point.key, measured).map_err(failed)?;
                    }
                    found = true;
                    break;
                }
                Ok(None) => {}
                Err(Refused::OtherBuild(build)) => refused = Some((file, build)),
                Err(Refused::Damaged(why)) => {
                    console::tell(format_args!("{}: {why}; the point is not taken", file.display()))
                }
            }
        }
        match (found, refused) {
            (true, _) => {}
            (false, Some(refused)) => {
                of_other_builds += 1;
                foreign.get_or_insert(refused);
            }
            (false, None) => missing.push(*point),
        }
    }
    if let Some((path, build)) = foreign {
        return Err(SweepError::OtherBuild { path, points: of_other_builds, of: plan.points.len(), build });
    }
    if missing.is_empty() {
        return Ok(());
    }
    let commands = commands(plan, &missing, own, others, command);
    Err(SweepError::Missing { missing: missing.len(), of: plan.points.len(), commands })
}

/// Commands that make the points `missing`: one for each shard that has any, in the folder where the shard was begun.
fn commands(
    plan: &Plan,
    missing: &[Point],
    own: &Path,
    others: &[PathBuf],
    command: impl Fn(Shard, &Path) -> String,
) -> Vec<String> {
    let identity = plan.identity();
    let folders = || others.iter().map(PathBuf::as_path).chain([own]);
    let noted: Vec<(Shard, &Path)> = folders()
        .flat_map(|folder| Places::of(folder).noted(&identity).into_iter().map(move |shard| (shard, folder)))
        .collect();
    let of = noted.iter().map(|(shard, _)| shard.of()).max().unwrap_or(1);
    let first = folders().next().unwrap_or(own);
    let missing: BTreeSet<_> = missing.iter().map(|point| point.key).collect();
    let dealt = plan.points.iter().zip(plan.deal(of)).filter(|(point, _)| missing.contains(&point.key));
    let incomplete: BTreeSet<usize> = dealt.map(|(_, shard)| shard).collect();
    let begun = |shard| noted.iter().find(|(other, _)| *other == shard).map_or(first, |(_, folder)| folder);
    Shard::all(of)
        .filter(|shard| incomplete.contains(&shard.index()))
        .map(|shard| command(shard, begun(shard)))
        .collect()
}
