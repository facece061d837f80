//! The rows of a profile's `results.csv`: the machine's statistics, and misses of caches of all sizes.

use super::data::ReuseSummary;
use crate::report::error::ReportError;
use crate::report::results::{Amount, Family, Results, Row, Scope, Subject, Take, Walk};
use crate::stats::ReuseCurve;

/// The column of a cache's size: empty for the machine's own caches.
const SIZE: &str = "cache.bytes";

impl Results for ReuseSummary {
    fn varied(&self) -> Vec<&str> {
        vec![SIZE]
    }

    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let family = Family::new("machines.*.policies.*.", "");
        let own = Subject {
            run: "profile",
            scene: &self.scene,
            scope: Scope::Total,
            frame: None,
            policy: &self.policy,
            machine: Some((&self.machine, "Profile")),
            varied: &[None],
        };
        Walk { family: &family, of: own, part: None, half_width: &|_| None }.rows(&self.stats, take)?;
        for level in &self.levels {
            for (class, curve) in &level.classes {
                let scale = curve.accesses as f64 / curve.sampled.max(1.0);
                for (size, misses) in ReuseCurve::sizes().zip(&curve.misses) {
                    let size = size.to_string();
                    let varied = [Some(size.as_str())];
                    let of = Subject { varied: &varied, ..own };
                    let (part, class) = (Some(level.name.as_str()), Some(class.name()));
                    let counts = [
                        ("caches.x.node.accesses", Amount::Whole(curve.accesses.into())),
                        ("caches.x.node.misses", Amount::Real(misses * scale)),
                    ];
                    for (path, value) in counts {
                        let Some(metric) = family.metric(path) else { continue };
                        take(&Row { of, part, class, metric, value: Some(value), half_width: None })?;
                    }
                }
            }
        }
        Ok(())
    }
}
