//! The kd-tree's figures in MODEL.md, on the BART kitchen.

mod common;

use std::convert::Infallible;

use common::shared;
use umbrasim::accel::{Accel, AccelSpec, KdLayout, Quality};
use umbrasim::culling::{PolicySpec, SceneFacts};
use umbrasim::memory::replacement::Policy;
use umbrasim::memory::tags::TagArray;
use umbrasim::quantity::{LineAddr, NodeId, Resolution};
use umbrasim::ranged::Within;
use umbrasim::scene::{RenderSpec, Scene, aff};
use umbrasim::stats::TrafficClass;
use umbrasim::stream::{Item, Step, Structure};
use umbrasim::tracer::{Tracer, TracerSpec};

/// The deepest tree that there can be.
const DEEP: Option<Within<1, 64>> = Some(Within::literal(64));

fn kd() -> AccelSpec {
    AccelSpec { structure: Structure::KdTree, ..AccelSpec::default() }
}

fn kitchen() -> Option<Scene> {
    shared("bart/kitchen/aff/kitchen.aff").map(|path| aff::load(&path).expect("a scene"))
}

#[test]
fn trees_of_the_kitchen_have_the_nodes_that_are_written_down() {
    let Some(scene) = kitchen() else { return };
    let settings = [(Quality::Best, None), (Quality::Medium, None), (Quality::Best, DEEP)];
    // With the node that joins the static and the dynamic tree.
    let found = settings.map(|(statics, kd_depth)| {
        let accel = Accel::new(&scene, AccelSpec { statics, kd_depth, ..kd() });
        (accel.static_nodes(), accel.static_list_entries())
    });
    assert_eq!(found, [(512_656, 368_028), (473_122, 391_100), (831_734, 522_921)]);
}

/// Misses in a million of a node cache of 8 KB, 4 ways, 64-byte lines, LRU, of rays one after another.
fn misses(scene: &Scene, kd_layout: KdLayout, kd_depth: Option<Within<1, 64>>) -> u64 {
    const NODES_A_LINE: u32 = 64 / 8;
    let resolution = Resolution { width: 512, height: 512 };
    let spec = TracerSpec {
        render: RenderSpec { depth: 4, ..RenderSpec::default() },
        accel: AccelSpec { kd_layout, kd_depth, ..kd() },
        ..TracerSpec::default()
    };
    let tracer = Tracer::new(scene, &scene.animation.frame(0), resolution, spec);
    let mut policies = [PolicySpec::Off.build(SceneFacts::of(scene))];
    let mut tags = TagArray::new(8192 / 64 / 4, 4, 0, Policy::Lru);
    let (mut accesses, mut missed) = (0, 0);
    for number in [0, 200, 400, 600] {
        let Ok(_) = tracer.frame(&scene.animation.frame(number), &mut policies, |_, item| {
            let Item::Rays(chunk) = item else { return Ok::<_, Infallible>(()) };
            for ray in chunk.rays() {
                for step in Step::unpack_all(ray.packed_path()) {
                    let Step::Node(NodeId(node)) = step else { continue };
                    let line = LineAddr(u64::from(node / NODES_A_LINE));
                    accesses += 1;
                    if !tags.access(line, false) {
                        tags.fill(line, TrafficClass::Node, false);
                        missed += 1;
                    }
                }
            }
            Ok(())
        });
    }
    missed * 1_000_000 / accesses
}

/// Some minutes: with the environment variable `UMBRASIM_LONG` only.
#[test]
fn node_caches_miss_what_is_written_down() {
    if std::env::var_os("UMBRASIM_LONG").is_none() {
        println!("skipped: UMBRASIM_LONG is not set");
        return;
    }
    let Some(scene) = kitchen() else { return };
    let settings = [
        (KdLayout::DepthFirst, None),
        (KdLayout::Ordered, None),
        (KdLayout::DepthFirst, DEEP),
        (KdLayout::Ordered, DEEP),
    ];
    let found = settings.map(|(layout, depth)| misses(&scene, layout, depth));
    assert_eq!(found, [58_074, 52_258, 61_977, 48_419]);
}
