//! Scenes made in code: nothing to download, the same on every run.

pub mod cases;
pub(crate) mod shapes;

mod made;
mod paint;
mod room;
mod street;
mod thicket;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::frame::Scene;
use crate::ranged::Within;
use cases::Case;
use made::Frames;

/// A number of lights.
pub type Lights = Within<1, 6>;
/// A scene made in code. Motion is a frame at a time, whatever the number of frames: more frames show more of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum BuiltInSpec {
    /// A furnished room with lamps, in which a toy train runs.
    Room {
        /// Lamps that are on.
        #[serde(default = "number::<4, 1, 6>")]
        lights: Lights,
        /// Frames of the animation.
        #[serde(default = "number::<120, 1, 1_000_000>")]
        frame_count: Frames,
        /// How finely it is tiled: twice as much gives two to four times the triangles.
        #[serde(default = "number::<4, 1, 32>")]
        detail: Within<1, 32>,
    },
    /// A street of houses and trees at dusk, with people walking.
    Street {
        /// Street lamps that are on.
        #[serde(default = "number::<6, 1, 6>")]
        lights: Lights,
        /// Frames of the animation.
        #[serde(default = "number::<120, 1, 1_000_000>")]
        frame_count: Frames,
        /// Houses on each side.
        #[serde(default = "number::<8, 1, 64>")]
        houses: Within<1, 64>,
        /// People walking.
        #[serde(default = "number::<12, 1, 256>")]
        walkers: Within<1, 256>,
    },
    /// Grass and leaves of many small triangles, with balls that bounce: a stress test.
    Thicket {
        /// Lights in the sky.
        #[serde(default = "number::<2, 1, 6>")]
        lights: Lights,
        /// Frames of the animation.
        #[serde(default = "number::<120, 1, 1_000_000>")]
        frame_count: Frames,
        /// Triangles of grass and leaves.
        #[serde(default = "number::<100_000, 1_000, 10_000_000>")]
        triangles: Within<1_000, 10_000_000>,
    },
    /// A small scene to test culling with. Its numbers are for its own [resolution](Case::resolution) and [way of
    /// rendering](Case::render).
    Case(Case),
}

/// A default of a ranged field.
fn number<const VALUE: u64, const LO: u64, const HI: u64>() -> Within<LO, HI> {
    Within::new(VALUE).expect("defaults are within their range")
}

/// Makes a scene.
pub fn build(spec: &BuiltInSpec) -> Scene {
    match spec {
        BuiltInSpec::Room { lights, frame_count, detail } => {
            room::build(lights.size(), detail.size()).into_scene("room", *frame_count)
        }
        BuiltInSpec::Street { lights, frame_count, houses, walkers } => {
            street::build(lights.size(), houses.size(), walkers.size()).into_scene("street", *frame_count)
        }
        BuiltInSpec::Thicket { lights, frame_count, triangles } => {
            thicket::build(lights.size(), triangles.size()).into_scene("thicket", *frame_count)
        }
        BuiltInSpec::Case(case) => case.scene(),
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::scene::frame::Frame;
    use crate::scene::geometry::Triangle;

    fn of(text: &str) -> Scene {
        build(&ron::from_str(text).unwrap())
    }

    const ALL: [&str; 3] = ["Room()", "Street()", "Thicket()"];

    fn bounds(triangles: &[Triangle]) -> [Vec3; 2] {
        let corners = || triangles.iter().flat_map(|triangle| triangle.v);
        [corners().fold(Vec3::INFINITY, Vec3::min), corners().fold(Vec3::NEG_INFINITY, Vec3::max)]
    }

    #[test]
    fn default_scenes_have_known_numbers_of_triangles() {
        let counts = ALL.map(of).map(|scene| [scene.statics.len(), scene.dynamic_count, scene.light_count]);
        assert_eq!(counts, [[28_308, 1_468, 4], [74_454, 11_400, 6], [104_608, 4_800, 2]]);
    }

    #[test]
    fn parameters_do_what_they_say() {
        let [coarse, fine] = ["Room(detail: 2)", "Room(detail: 8)"].map(|text| of(text).statics.len());
        assert!((4 * coarse..=16 * coarse).contains(&fine), "{coarse} {fine}");
        // The ground has 48 x 48 tiles.
        assert_eq!(of("Thicket(triangles: 12345)").statics.len(), 12_345 + 2 * 48 * 48);
        let [few, many] = ["Street(walkers: 2, houses: 2)", "Street(walkers: 6, houses: 4)"].map(of);
        assert_eq!(3 * few.dynamic_count, many.dynamic_count);
        assert!(few.statics.len() < many.statics.len());
        for count in 1..=6 {
            for name in ["Room", "Street", "Thicket"] {
                assert_eq!(of(&format!("{name}(lights: {count})")).animation.frame(0).lights.len(), count);
            }
        }
    }

    #[test]
    fn a_scene_made_twice_is_the_same() {
        for text in ALL {
            let (one, two) = (of(text), of(text));
            assert_eq!(one.statics, two.statics);
            assert_eq!((&one.materials, &one.textures), (&two.materials, &two.textures));
            let [one, two] = [one, two].map(|scene| scene.animation.frame(17));
            assert_eq!((one.dynamic, one.camera, one.lights), (two.dynamic, two.camera, two.lights));
        }
    }

    #[test]
    fn all_that_is_dynamic_moves_and_keeps_its_shape() {
        for text in ALL {
            let scene = of(text);
            let [one, two] = [5, 6].map(|number| scene.animation.frame(number));
            assert_eq!(one.dynamic.len(), scene.dynamic_count);
            assert_ne!(one.camera, two.camera);
            assert_eq!(one.dynamic.attributes.len(), one.visible.len());
            for (before, after) in one.dynamic.triangles.iter().zip(&two.dynamic.triangles) {
                assert_ne!(before, after, "{text}");
                let edges = |t: &Triangle| [0, 1, 2].map(|i| t.v[i].distance(t.v[(i + 1) % 3]));
                for (before, after) in edges(before).into_iter().zip(edges(after)) {
                    assert!((before - after).abs() < 2e-5, "{text}: {before} {after}");
                }
            }
        }
    }

    #[test]
    fn everything_is_where_it_belongs() {
        let inside = |low: Vec3, high: Vec3, of: [Vec3; 2]| of[0].cmpge(low).all() && of[1].cmple(high).all();
        for (text, low, high) in [
            // The window is open, and a plant leans out.
            ("Room()", Vec3::new(-3.2, -0.01, -2.51), Vec3::new(3.01, 2.75, 2.51)),
            ("Street()", Vec3::new(-40.0, -0.01, -115.0), Vec3::new(40.0, 12.5, 6.0)),
            ("Thicket()", Vec3::new(-4.6, -0.3, -4.6), Vec3::new(4.6, 2.0, 4.6)),
        ] {
            let scene = of(text);
            assert!(inside(low, high, bounds(&scene.statics.triangles)), "{:?}", bounds(&scene.statics.triangles));
            for number in [0, 1, 59, 119, 5_000] {
                let Frame { dynamic, camera, lights, .. } = scene.animation.frame(number);
                assert!(inside(low, high, bounds(&dynamic.triangles)), "{text} {:?}", bounds(&dynamic.triangles));
                let eye = camera.eye.as_vec3();
                assert!(text == "Thicket()" || inside(low, high, [eye, eye]), "{text} {eye}");
                assert!(camera.up.is_finite() && lights.iter().all(|light| light.position.is_finite()));
            }
            for geometry in [&scene.statics, &scene.animation.frame(3).dynamic] {
                let degenerate = geometry.triangles.iter().filter(|t| t.normal().length_squared() == 0.0).count();
                assert_eq!(degenerate, 0, "{text}");
                for attributes in &geometry.attributes {
                    assert!((attributes.material.0 as usize) < scene.materials.len());
                    assert!(attributes.normals.is_none_or(|n| n.iter().all(|n| (n.length() - 1.0).abs() < 1e-5)));
                }
            }
        }
    }

    #[test]
    fn each_scene_has_a_mirror_glass_and_a_texture() {
        for text in ALL {
            let scene = of(text);
            assert!(scene.materials.iter().any(|material| material.specular.min_element() > 0.4), "{text}");
            assert!(scene.materials.iter().any(|material| material.transmittance > 0.5), "{text}");
            assert!(scene.materials.iter().any(|material| material.texture.is_some()), "{text}");
        }
    }
}
