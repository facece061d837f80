//! The kd-tree's sizes in MODEL.md, on the BART kitchen.

mod common;

use common::shared;
use umbrasim::accel::{Accel, AccelSpec, Quality};
use umbrasim::ranged::Within;
use umbrasim::scene::aff;
use umbrasim::stream::Structure;

#[test]
fn trees_of_the_kitchen_have_the_nodes_that_are_written_down() {
    let Some(path) = shared("bart/kitchen/aff/kitchen.aff") else { return };
    let scene = aff::load(&path).expect("a scene");
    let deep = const { Some(Within::literal(64)) };
    let found = [(Quality::Best, None), (Quality::Medium, None), (Quality::Best, deep)].map(|(statics, kd_depth)| {
        let spec = AccelSpec { structure: Structure::KdTree, statics, kd_depth, ..AccelSpec::default() };
        let accel = Accel::new(&scene, spec);
        // With the node that joins the static and the dynamic tree.
        (accel.static_nodes(), accel.static_list_entries())
    });
    assert_eq!(found, [(512_656, 368_028), (473_122, 391_100), (831_734, 522_921)]);
}
