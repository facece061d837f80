//! Measurements of a timing run, as plain data: timing fills it, reports read it, and neither depends on the other.

mod accuracy;
mod choice;
mod counts;
mod difference;
mod energy;
mod frames;
mod machine;
mod residuals;
mod reuse;
mod traffic;

pub use accuracy::{Accuracy, Bounds, Limit, Range};
pub use choice::{Choice, Why};
pub use counts::{CacheCounts, CacheStats, DramCounts, L1Counts, LatencyCounts, QueueCounts};
pub use energy::Energy;
pub use frames::FrameStats;
pub use machine::MachineStats;
pub(crate) use machine::half_width_of_ratio;
pub use residuals::{Change, Residual, Residuals};
pub use reuse::{FrameReuse, ReuseCurve, ReuseLevel};
pub use traffic::{Cause, TrafficClass};
