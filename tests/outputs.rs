//! What commands write: outputs destroy nothing, kept results are never stale, and whatever ends a command leaves
//! nothing that looks complete and is not.

mod common;
#[path = "outputs/files.rs"]
mod files;
#[path = "outputs/kills.rs"]
mod kills;
#[path = "outputs/reports.rs"]
mod reports;
#[path = "outputs/shards.rs"]
mod shards;
#[path = "outputs/spaces.rs"]
mod spaces;
#[path = "outputs/sweeps.rs"]
mod sweeps;
#[path = "outputs/versions.rs"]
mod versions;
