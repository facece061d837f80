//! Where a scene comes from, as a config says it.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::aff;
use super::builtin::{self, BuiltInSpec};
use super::composed::{self, ComposedSpec};
use super::error::SceneError;
use super::frame::Scene;

/// Where a scene comes from. Paths are relative to the folder of the config.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub enum SceneSpec {
    /// An AFF file of the BART suite.
    Aff(PathBuf),
    /// Files of triangles (OBJ, PLY, glTF) with lights, a camera and moving objects.
    #[serde(alias = "Obj")]
    Files(ComposedSpec),
    /// A scene made in code.
    BuiltIn(BuiltInSpec),
}

impl SceneSpec {
    /// The scene; `base` is the folder of the config.
    ///
    /// # Errors
    /// Files that cannot be read, are malformed, or hold no scene.
    pub fn load(&self, base: &Path) -> Result<Scene, SceneError> {
        match self {
            Self::Aff(path) => aff::load(&base.join(path)),
            Self::Files(spec) => composed::load(spec, base),
            Self::BuiltIn(spec) => Ok(builtin::build(spec)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOT: &str = env!("CARGO_MANIFEST_DIR");

    /// The scene of a config in `configs/scenes`; `None` if its files are absent.
    fn load(name: &str, needs: Option<&str>) -> Option<Scene> {
        if let Some(missing) = needs.map(|file| Path::new(ROOT).join(file)).filter(|file| !file.exists()) {
            println!("skipped: {} is absent", missing.display());
            return None;
        }
        let folder = Path::new(ROOT).join("configs/scenes");
        let text = std::fs::read_to_string(folder.join(name).with_extension("ron")).unwrap();
        let options = ron::Options::default().with_default_extension(
            ron::extensions::Extensions::IMPLICIT_SOME | ron::extensions::Extensions::UNWRAP_VARIANT_NEWTYPES,
        );
        let spec: SceneSpec = options.from_str(&text).unwrap();
        let again: SceneSpec = options.from_str(&options.to_string(&spec).unwrap()).unwrap();
        assert_eq!(spec, again, "a config survives being written out");
        Some(spec.load(&folder).unwrap())
    }

    /// Numbers of static triangles, moving triangles, lights and frames.
    fn counts(scene: &Scene) -> [usize; 4] {
        [scene.statics.len(), scene.dynamic_count, scene.light_count, scene.frame_count as usize]
    }

    #[test]
    fn the_living_room_has_the_published_number_of_triangles() {
        let Some(scene) = load("living_room", Some("../shared/scenes/living-room/living-room.obj")) else { return };
        assert_eq!(counts(&scene), [143_163, 6_320, 4, 60]);
    }

    #[test]
    fn the_staircase_has_the_published_number_of_triangles() {
        let Some(scene) = load("staircase", Some("../shared/scenes/staircase2/staircase2.obj")) else { return };
        assert_eq!(counts(&scene), [30_911, 960, 3, 60]);
        // Eight materials of the library, the default material, and the ball's material.
        assert_eq!(scene.materials.len(), 10);
    }

    #[test]
    fn sponza_sibenik_and_the_gltf_scenes_have_the_published_numbers_of_triangles() {
        for (name, needs, expected) in [
            ("sponza", "dabrovic-sponza/sponza.obj", [66_450, 0, 1, 5]),
            ("sibenik", "sibenik/sibenik.obj", [73_564, 0, 1, 5]),
            ("crytek_sponza", "crytek-sponza/Sponza.gltf", [262_087, 0, 3, 1]),
            // A ball rolls.
            ("gas_station", "gas-station/GasStation.gltf", [99_002, 528, 3, 60]),
        ] {
            let Some(scene) = load(name, Some(&format!("../shared/scenes/{needs}"))) else { continue };
            assert_eq!(counts(&scene), expected, "{name}");
        }
    }

    #[test]
    fn the_configs_of_built_in_scenes_are_their_defaults() {
        for (name, text) in
            [("room", "BuiltIn(Room())"), ("street", "BuiltIn(Street())"), ("thicket", "BuiltIn(Thicket())")]
        {
            let default: SceneSpec = ron::from_str(text).unwrap();
            let default = default.load(Path::new(".")).unwrap();
            let scene = load(name, None).unwrap();
            assert_eq!(counts(&scene), counts(&default));
            assert_eq!(scene.name, name);
        }
        assert!(ron::from_str::<SceneSpec>("BuiltIn(Room(lights: 7))").is_err());
        assert!(ron::from_str::<SceneSpec>("BuiltIn(Room(lamps: 2))").is_err());
    }
}
