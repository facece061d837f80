//! Outputs: files and folders of results that appear only when complete, and destroy nothing.
//!
//! - [`OutputFile`] is a file that the user names: a regular file is replaced as a whole; a device, a pipe and `-` are
//!   written to directly.
//! - [`ResultsFolder`] is a folder of results that one process at a time writes, in which foreign files stay.
//! - [`SharedFolder`] is a folder in which several processes keep results one by one; [`Turn`] decides which process
//!   makes one of the results.
//! - [`claim_file`] and [`claim_folder`] refuse outputs that the same command reads, or writes twice.
//! - [`signals`] ends the program without leaving temporary files behind.

mod carry;
pub(crate) mod claims;
mod error;
mod exchange;
mod file;
mod folder;
mod identity;
mod leftovers;
mod links;
mod lock;
mod names;
mod registry;
pub(crate) mod signals;
mod temporary;
#[cfg(test)]
mod tests;
mod turn;

pub(crate) use claims::{claim_file, claim_folder, is_standard_output_claimed};
pub(crate) use error::FolderError;
pub(crate) use file::{OutputFile, write_whole};
pub(crate) use folder::{ResultsFolder, SharedFolder};
pub(crate) use leftovers::sweep as remove_leftovers;
pub(crate) use links::unlink;
pub(crate) use temporary::TemporaryFolder;
pub(crate) use turn::Turn;
