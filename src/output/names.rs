//! The names of temporary files and folders.

/// Every temporary name in a user's folder begins with this.
pub(super) const PREFIX: &str = ".umbrasim-";
/// The end of a temporary file's name.
pub(super) const FILE_SUFFIX: &str = ".part";
/// The end of a temporary folder's name.
pub(super) const FOLDER_SUFFIX: &str = ".work";
/// The end of a lock file's name.
pub(super) const LOCK_SUFFIX: &str = ".lock";
/// In a temporary folder: the folder that is to take its place.
pub(super) const NEW: &str = "new";
/// In a temporary folder: holds the earlier folder, under its own name, until the new one is in place.
pub(super) const EARLIER: &str = "earlier";
