//! The stack of cells that a ray visits later, and the cost of a short stack. A full short stack drops its deepest
//! entry. A ray that needs this entry goes down again from the node where its paths first split ("short stack" with
//! "push-down"; Horn et al. 2007, "Interactive k-D Tree GPU Raytracing"; the T&I engine has four entries).
//!
//! This model keeps all entries, also dropped ones, with the path to the current node. A restart visits the nodes of
//! that path again, so the stack's size cannot change what a ray hits.

use crate::accel::trail::Observer;
use crate::quantity::NodeId;

/// A cell that the ray crosses between the distances `enter` and `exit`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// The cell's node.
    pub node: u32,
    /// The distance at which the ray enters.
    pub enter: f32,
    /// The distance at which the ray leaves.
    pub exit: f32,
    /// The node's level; 0 is a tree's root.
    pub depth: u32,
}

/// A ray's stack in a walk of the trees.
#[derive(Debug)]
pub(super) struct Stack {
    entries: Vec<Span>,
    /// Number of places, if limited.
    places: Option<usize>,
    /// Number of entries at the bottom that are dropped.
    dropped: usize,
    /// Nodes on the path to the current node, by level.
    path: Vec<u32>,
    /// The level from which a restart goes down: the first split with a side still to visit.
    restart: Option<u32>,
}

impl Stack {
    /// A stack of `places`, or without a limit, for a walk of `trees`; the last of them is walked first. Their roots
    /// are in registers.
    pub(super) fn new(places: Option<usize>, trees: Vec<Span>) -> Self {
        let mut entries = trees;
        entries.reserve(64);
        Self { entries, places, dropped: 0, path: Vec::new(), restart: None }
    }

    /// Adds a visited node to the path.
    pub(super) fn visit(&mut self, span: &Span) {
        if self.places.is_some() {
            self.path.truncate(span.depth as usize);
            self.path.push(span.node);
        }
    }

    /// Pushes `span`, a child of the current node that the ray visits later.
    pub(super) fn push(&mut self, span: Span) {
        self.entries.push(span);
        if let Some(places) = self.places {
            self.restart.get_or_insert(span.depth - 1);
            let kept = self.entries[self.dropped..].iter().filter(|entry| entry.depth > 0).count();
            if kept > places {
                self.dropped += 1;
                // Roots are never dropped: the next entry above is dropped instead.
                while self.entries[self.dropped - 1].depth == 0 {
                    self.dropped += 1;
                }
            }
        }
    }

    /// Pops the next cell that the ray enters within `reach`. If the cell was dropped, the nodes on the path to it are
    /// visited again.
    pub(super) fn pop(&mut self, reach: f32, watch: &mut impl Observer) -> Option<Span> {
        let span = loop {
            let span = self.entries.pop()?;
            if span.enter <= reach {
                break span;
            }
        };
        let Some(places) = self.places else { return Some(span) };
        if span.depth == 0 {
            // The walk begins another tree.
            (self.restart, self.dropped) = (None, self.dropped.min(self.entries.len()));
        } else if self.entries.len() < self.dropped {
            let way = self.restart.unwrap_or(0) as usize..span.depth as usize;
            self.path[way].iter().for_each(|&node| watch.node(NodeId(node)));
            // The way down finds the last `places` pending entries again; earlier paths are finished.
            let left = || self.entries.iter().filter(|entry| entry.depth > 0);
            self.restart = left().map(|entry| entry.depth - 1).min();
            self.dropped = self.entries.len() - places.min(left().count());
        }
        Some(span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::trail::Trail;

    /// Nodes visited again by a ray that goes down five levels, leaves a cell for later on each level, and then visits
    /// all these cells.
    fn visited_again(places: Option<usize>) -> Vec<u32> {
        let span = |node, depth| Span { node, enter: 0.0, exit: 1.0, depth };
        let (mut stack, mut trail) = (Stack::new(places, vec![span(0, 0)]), Trail::default());
        let mut here = stack.pop(1.0, &mut trail).unwrap();
        for depth in 1..=5 {
            stack.visit(&here);
            stack.push(span(100 + depth, depth));
            here = span(depth, depth);
        }
        for depth in (1..=5).rev() {
            assert_eq!(stack.pop(1.0, &mut trail).unwrap().node, 100 + depth);
        }
        assert!(stack.pop(1.0, &mut trail).is_none());
        let node = |step| if let crate::stream::Step::Node(NodeId(node)) = step { Some(node) } else { None };
        crate::stream::Step::unpack_all(&trail.steps).filter_map(node).collect()
    }

    #[test]
    fn what_was_dropped_is_found_from_where_the_ways_parted() {
        assert!(visited_again(None).is_empty());
        assert!(visited_again(Some(5)).is_empty());
        // Levels 4 and 5 are kept. The restart to level 3 finds those of levels 1 and 2 again.
        assert_eq!(visited_again(Some(2)), [0, 1, 2]);
        // Level 5 is kept. The restart to level 4 finds that of level 3; the one to level 2 finds that of level 1.
        assert_eq!(visited_again(Some(1)), [0, 1, 2, 3, 0, 1]);
    }

    #[test]
    fn what_lies_behind_the_hit_costs_no_restart() {
        let span = |node, enter, depth| Span { node, enter, exit: 9.0, depth };
        let (mut stack, mut trail) = (Stack::new(Some(1), vec![]), Trail::default());
        stack.visit(&span(0, 0.0, 0));
        stack.push(span(7, 5.0, 1));
        stack.visit(&span(1, 0.0, 1));
        stack.push(span(8, 2.0, 2));
        assert_eq!(stack.pop(3.0, &mut trail).unwrap().node, 8);
        assert!(stack.pop(3.0, &mut trail).is_none());
        assert!(trail.steps.is_empty());
    }
}
