//! Change of each figure from one report to the other, one bar per figure.

use super::data::{Diff, changes, told};
use super::figures::Figure as Compared;
use crate::report::draw::changes::{Bar, Bars};
use crate::report::draw::palette::{ORANGE, SKY};
use crate::report::draw::{Figure, Plot};
use crate::report::format::signed;

pub(super) const PLOT: Plot<Diff> = Plot { name: "changes", section: (), figure };

/// Number of figures that the plot shows, the largest changes first; the others are in the table alone.
const MOST: usize = 30;

fn figure(diff: &Diff) -> Option<Figure<'_>> {
    let mut changes = changes(diff);
    let left_out = changes.len().saturating_sub(MOST);
    changes.truncate(MOST);
    let (first, change) = changes.first()?;
    let rest = if left_out > 0 { format!(" {left_out} smaller changes are in the table.") } else { String::new() };
    let bars = Bars { groups: vec![(None, changes.iter().map(bar).collect())], colors: [SKY, ORANGE] };
    let height = bars.height();
    Some(Figure {
        title: told(first, *change),
        about: format!("Change of each figure from A to B, as a share of A's.{rest}"),
        key: vec![("less in B".into(), SKY), ("more in B".into(), ORANGE)],
        data: diff.figures_grid(),
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| bars.paint(canvas)),
    })
}

fn bar((figure, change): &(&Compared, f64)) -> Bar {
    let text = format!("{}: {}", figure.name(), signed(*change));
    Bar { short: text.clone(), text, least: change.min(0.0), most: change.max(0.0) }
}
