//! Misses over the size of each cache.

use super::machine::{Machine, MachinePlot};
use crate::report::draw::Figure;
use crate::report::reuse;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "reuse", figure };

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let found = machine.found.reuse.as_ref()?;
    let asked = format!(
        "Asked by {}, a twentieth of the lines and the hottest, in frame {} alone, as if the frame came again and \
         again.",
        found.policy, found.frame
    );
    let title = format!("{}: {}", machine.name, reuse::finding(&found.levels));
    Some(reuse::figure(&found.levels, title, asked))
}
