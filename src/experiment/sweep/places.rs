//! The folders in which a sweep keeps its streams and points.

use std::path::{Path, PathBuf};

use super::error::SweepError;
use super::shard::Shard;
use crate::output::{remove_leftovers, write_whole};

/// The subfolders of a sweep's folder.
pub(in super::super) struct Places {
    pub(in super::super) points: PathBuf,
    pub(in super::super) streams: PathBuf,
    /// A folder with a file for each shard that was begun. From these a collector derives the commands for missing
    /// points.
    shards: PathBuf,
}

impl Places {
    /// The subfolders of `folder`.
    pub(in super::super) fn of(folder: &Path) -> Self {
        let [points, streams, shards] = ["points", "streams", "shards"].map(|part| folder.join(part));
        Self { points, streams, shards }
    }

    /// Makes missing folders, and removes what killed processes left in existing ones.
    ///
    /// # Errors
    /// A folder cannot be made.
    pub(in super::super) fn make(&self) -> Result<(), SweepError> {
        [&self.points, &self.streams, &self.shards].into_iter().try_for_each(|part| {
            std::fs::create_dir_all(part).map_err(|source| SweepError::File { path: part.clone(), source })?;
            remove_leftovers(part);
            Ok(())
        })
    }

    /// Notes that a shard of the plan `identity` was begun here.
    ///
    /// # Errors
    /// The note cannot be written.
    pub(super) fn note(&self, identity: &str, shard: Shard) -> Result<(), SweepError> {
        let path = self.shards.join(format!("{identity}_{}_of_{}", shard.index() + 1, shard.of()));
        if path.exists() {
            return Ok(());
        }
        write_whole(&path, b"").map_err(|source| SweepError::File { path: path.clone(), source })
    }

    /// The shards of the plan `identity` that were begun here.
    pub(super) fn noted(&self, identity: &str) -> Vec<Shard> {
        let entries = std::fs::read_dir(&self.shards).into_iter().flatten().flatten();
        let shard = |name: &str| name.strip_prefix(identity)?.strip_prefix('_')?.replace("_of_", "/").parse().ok();
        entries.filter_map(|entry| shard(entry.file_name().to_str()?)).collect()
    }
}
