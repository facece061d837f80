//! How a ray walks a packed tree: one loop for both widths.
//!
//! Children are visited nearest first, unless a shadow ray asks for another order; ties follow the node's own order. A
//! child that is behind the nearest hit when it is taken from the stack is dropped without a visit.

use pulp::NullaryFnOnce;

use super::forest::Forest;
use super::packed::{Goal, Packing, Wide};
use super::question::{Blocker, Nearest, Question};
use super::stack::Stack;
use super::tree::Tree;
use crate::accel::block::{Block, LANES, Line};
use crate::accel::lanes::{Lanes, Plain, Processor};
use crate::accel::query::{Hit, Order, Scope};
use crate::accel::ray::Ray;
use crate::accel::slabs::{Slabs, limit};
use crate::accel::trail::Observer;
use crate::accel::triangle::Record;
use crate::quantity::{NodeId, PrimitiveId, TriangleSlot};

/// Where a walk begins.
#[derive(Clone, Copy)]
enum Start {
    /// At the roots of the trees in the scope.
    Roots(Scope),
    /// At a node of the static tree.
    Node(NodeId),
}

/// A walk of one or two trees.
struct Walk<'a, 'q, L, Q, W, const N: usize>
where
    Tree<N>: Wide<N>,
{
    lanes: L,
    forest: &'a Forest<'a, N>,
    start: Start,
    question: &'q mut Q,
    watch: &'q mut W,
}

impl<'a, L: Processor, Q: Question<'a>, W: Observer, const N: usize> Walk<'a, '_, L, Q, W, N>
where
    Tree<N>: Wide<N>,
{
    #[inline(always)]
    fn go(self) {
        let Self { lanes, forest, start, question, watch } = self;
        let mut slabs = Slabs::new(lanes, question.ray());
        let line = Line::new(lanes, question.ray());
        let places = forest.packed.stack.max(forest.packed_dynamic.stack);
        let (mut few, mut many) = (Node::<N>::few(), Vec::new());
        let places = if places <= few.as_mut().len() {
            few.as_mut()
        } else {
            many.resize(places, Default::default());
            many.as_mut_slice()
        };
        let mut stack = Stack::new(places);
        let mut last = limit(question.ray());
        // A bit for each tree to walk, the distances at which the ray enters their boxes, the first static node, and
        // whether the dynamic tree goes first.
        let (mut met, mut entries, mut first, mut swap) = (1, [0.0; 8], 0, false);
        match start {
            Start::Node(node) => first = node.0 as usize,
            Start::Roots(scope) if forest.joined => {
                watch.node(NodeId(0));
                (entries, met) = slabs.meet(&forest.boxes);
                met &= match scope {
                    Scope::All => 0b11,
                    Scope::Static => 0b01,
                    Scope::Dynamic => 0b10,
                };
                // A shadow ray walks the static tree first, so that a dynamic blocker proves that no static triangle
                // blocks.
                (first, swap) = (1, Q::SHORTENS && entries[1] < entries[0]);
            }
            Start::Roots(_) => {}
        }
        for turn in 0..2 {
            let tree = turn ^ usize::from(swap);
            if met >> tree & 1 == 0 || entries[tree] > last {
                continue;
            }
            let (packed, records, from) = match tree {
                0 => (forest.packed, &forest.statics.records, Goal::node(first)),
                _ => (&forest.packed_dynamic, &forest.dynamic.records, Goal::node(0)),
            };
            let mut next = Some(from);
            loop {
                let goal = match next {
                    Some(goal) => goal,
                    None => match Node::<N>::next(lanes, &packed.nodes, &mut stack, last) {
                        Some(goal) => goal,
                        None => break,
                    },
                };
                watch.make_room();
                let Some(mut place) = goal.block() else {
                    let node = &packed.nodes[goal.place()];
                    next = node.visit(lanes, goal, &slabs, question.order(), &mut stack, watch);
                    continue;
                };
                next = None;
                loop {
                    let block = &packed.blocks[place];
                    if test(block, packed.first_slot(), records, &line, question, watch) {
                        return;
                    }
                    if !block.goes_on {
                        break;
                    }
                    place += 1;
                    watch.make_room();
                }
                if Q::SHORTENS {
                    slabs.shorten(question.ray());
                    last = limit(question.ray());
                }
            }
        }
    }
}

/// Tests the triangles of a block; returns whether the query is answered.
#[inline(always)]
fn test<'a, L: Lanes<LANES>, Q: Question<'a>>(
    block: &Block,
    first_slot: u32,
    records: &'a [Record],
    line: &Line<L>,
    question: &mut Q,
    watch: &mut impl Observer,
) -> bool {
    let tested = block.test(line, question.ray().reach);
    let hits = tested.in_plane & tested.inside;
    let (count, slot) = (u32::from(block.count), first_slot + block.first);
    if hits == 0 {
        watch.missed(TriangleSlot(slot), count, tested.in_plane);
        return false;
    }
    let sure = hits.trailing_zeros();
    watch.missed(TriangleSlot(slot), sure, tested.in_plane);
    let each = tested.each();
    for at in sure..count {
        let (stop, hit) = each.result(at as usize, question.ray().reach);
        let (stop, is_answered) = match hit {
            None => (stop, false),
            Some(hit) => {
                question.hit(hit, block.primitives[at as usize % LANES], || &records[(block.first + at) as usize])
            }
        };
        watch.triangle(TriangleSlot(slot + at), stop);
        if is_answered {
            return true;
        }
    }
    false
}

/// A packed node of a tree of width `N`.
type Node<const N: usize> = <Tree<N> as Wide<N>>::Node;

impl<'a, L: Processor, Q: Question<'a>, W: Observer, const N: usize> NullaryFnOnce for Walk<'a, '_, L, Q, W, N>
where
    Tree<N>: Wide<N>,
{
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.go();
    }
}

impl<const N: usize> Forest<'_, N>
where
    Tree<N>: Wide<N>,
{
    /// Walks with the best vector instructions of the processor.
    #[inline]
    fn walk<'a, Q: Question<'a>>(&'a self, start: Start, mut question: Q, watch: &mut impl Observer) -> Q {
        let (forest, question_of) = (self, &mut question);
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = pulp::x86::V3::try_new() {
            lanes.vectorize(Walk { lanes, forest, start, question: question_of, watch });
            return question;
        }
        Walk { lanes: Plain, forest, start, question: question_of, watch }.go();
        question
    }

    /// The nearest hit; at equal distance, the hit on the lowest primitive.
    pub(crate) fn nearest(&self, ray: &Ray, watch: &mut impl Observer) -> Option<Hit> {
        self.walk(Start::Roots(Scope::All), Nearest { ray: *ray, hit: None }, watch).hit
    }

    /// A triangle that blocks the ray within `scope`: the first found in `order`. All static triangles are tried
    /// before the first dynamic one, so a dynamic blocker proves that no static triangle blocks.
    pub(crate) fn blocker(
        &self,
        ray: &Ray,
        scope: Scope,
        order: Order,
        watch: &mut impl Observer,
    ) -> Option<PrimitiveId> {
        if scope == Scope::Dynamic && !self.joined {
            return None;
        }
        self.walk(Start::Roots(scope), Blocker { ray, order, found: None }, watch).found
    }

    /// A triangle below a static node that blocks the ray; the nearest children are visited first.
    pub(crate) fn blocker_below(&self, ray: &Ray, node: NodeId, watch: &mut impl Observer) -> Option<PrimitiveId> {
        self.walk(Start::Node(node), Blocker { ray, order: Order::NearestFirst, found: None }, watch).found
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::accel::bvh::build::Build;
    use crate::accel::bvh::statics::Bvh;
    use crate::accel::spec::AccelSpec;
    use crate::accel::structure::{Item, StaticTree};
    use crate::accel::trail::Trail;
    use crate::scene::Triangle;

    /// Pseudo-random numbers from -1 to 1.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / f32::from_bits(0x4b00_0000) - 1.0
        }
    }

    fn vectors(mut number: impl FnMut() -> f32) -> impl FnMut() -> Vec3 {
        move || Vec3::new(number(), number(), number())
    }

    /// Rays in all directions, some perpendicular to an axis, with different reaches.
    fn rays() -> Vec<Ray> {
        let mut next = vectors(numbers());
        let ray = |number: usize| {
            let (origin, mut direction) = (next() * 2.0, next());
            if number.is_multiple_of(3) {
                direction[number % 9 / 3] = 0.0;
            }
            let reach = if number.is_multiple_of(2) { f32::INFINITY } else { number as f32 / 100.0 };
            Ray::new(origin, direction, reach)
        };
        (0..400).map(ray).collect()
    }

    /// Compares trails and answers of all rays in a tree over `triangles`, the last of which move. Returns the stack's
    /// size.
    fn check<const N: usize>(triangles: &[Triangle], moving: usize) -> usize
    where
        Tree<N>: Build + Wide<N>,
    {
        let items = (0..).zip(triangles).map(|(number, triangle)| Item { primitive: PrimitiveId(number), triangle });
        let items: Vec<_> = items.collect();
        let (fixed, moving) = items.split_at(items.len() - moving);
        let spec = AccelSpec::default();
        let tree = Bvh::<N>::build(fixed, &spec, !moving.is_empty());
        let forest = tree.join(moving, &spec);
        let records: Vec<_> = items.iter().map(|item| Record::new(item.triangle, item.primitive)).collect();
        for ray in rays() {
            let start = Start::Roots(Scope::All);
            let (mut best, mut plain) = (Trail::default(), Trail::default());
            let mut question = Nearest { ray, hit: None };
            Walk { lanes: Plain, forest: &forest, start, question: &mut question, watch: &mut plain }.go();
            assert_eq!(forest.nearest(&ray, &mut best), question.hit);
            let (mut reached, mut nearest) = (ray, None);
            records.iter().for_each(|record| _ = record.test_nearest(&mut reached, &mut nearest));
            assert_eq!(question.hit, nearest);
            for order in [Order::NearestFirst, Order::LargestFirst] {
                let mut question = Blocker { ray: &ray, order, found: None };
                Walk { lanes: Plain, forest: &forest, start, question: &mut question, watch: &mut plain }.go();
                assert_eq!(forest.blocker(&ray, Scope::All, order, &mut best), question.found);
                assert_eq!(question.found.is_some(), records.iter().any(|record| record.blocks(&ray).1));
            }
            assert_eq!(best.path().steps, plain.path().steps);
            assert_eq!((best.nodes, best.triangles), (plain.nodes, plain.triangles));
        }
        forest.packed.stack
    }

    #[test]
    fn arrays_walk_as_vectors_do() {
        let mut next = vectors(numbers());
        let triangle = |_| {
            let corner = next();
            Triangle { v: [corner, corner + 0.3 * next(), corner + 0.3 * next()] }
        };
        let triangles: Vec<_> = (0..300).map(triangle).collect();
        for moving in [0, 40] {
            check::<2>(&triangles, moving);
            check::<8>(&triangles, moving);
        }
    }

    #[test]
    fn a_tree_deeper_than_most_is_walked_too() {
        // Each triangle is half the size of the next, and all share a corner.
        let triangle = |number| {
            let size = f32::exp2(number as f32 - 110.0);
            Triangle { v: [Vec3::ZERO, Vec3::new(size, 0.0, size), Vec3::new(0.0, size, size)] }
        };
        let triangles: Vec<_> = (0..110).map(triangle).collect();
        let stack = check::<2>(&triangles, 0);
        assert!(stack > 64, "{stack}");
        check::<8>(&triangles, 0);
    }
}
