//! Tests of glTF files; `tests/fixtures/gltf` holds the results of independent readers for three of them.

use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use glam::Vec3;
use serde_json::{Value, json};

use super::accessor::Elements;
use super::*;
use crate::scene::material::Material;

/// The path of a compared file; `None` if it is absent.
fn file(name: &str) -> Option<PathBuf> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = match name {
        "yard" => root.join("tests/fixtures/gltf/yard.gltf"),
        "crytek-sponza" => root.join("../shared/scenes/crytek-sponza/Sponza.gltf"),
        _ => root.join("../shared/scenes/gas-station/GasStation.gltf"),
    };
    if !path.exists() {
        println!("skipped: {} is absent", path.display());
    }
    path.exists().then_some(path)
}

fn rows(name: &str) -> Vec<Vec<String>> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/gltf").join(name);
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn load(path: &Path) -> (Model, Loader) {
    let mut loader = Loader::default();
    loader.ignore_textures = true;
    let model = read(path, None, MaterialId(0), DAffine3::IDENTITY, &mut loader).unwrap();
    (model, loader)
}

#[test]
fn triangles_and_bounds_are_those_of_an_independent_reader() {
    for row in rows("counts.csv") {
        let Some(path) = file(&row[0]) else { continue };
        let (model, _) = load(&path);
        let mut all = model.statics;
        for (geometry, pose) in &model.moving {
            append(&mut all, geometry, pose(0.0)).unwrap();
        }
        assert_eq!(all.len().to_string(), row[1], "{}", row[0]);
        let corners = || all.triangles.iter().flat_map(|triangle| triangle.v);
        let low = corners().fold(Vec3::INFINITY, Vec3::min).to_array();
        let high = corners().fold(Vec3::NEG_INFINITY, Vec3::max).to_array();
        for (found, expected) in low.into_iter().chain(high).zip(&row[2..]) {
            let expected: f32 = expected.parse().unwrap();
            assert!((found - expected).abs() < 1e-5, "{}: {found} {expected}", row[0]);
        }
    }
}

#[test]
fn vertices_are_where_an_independent_reader_has_them_at_three_times() {
    let rows = rows("positions.csv");
    for name in ["yard", "crytek-sponza", "gas-station"] {
        let Some(path) = file(name) else { continue };
        let mut loader = Loader::default();
        let bytes = loader.files.read(&path).unwrap();
        let (root, chunk) = document::read(&bytes, &path, &mut loader).unwrap();
        let buffers = Buffers::read(&root, chunk, &path, &mut loader).unwrap();
        let motions = animation::read(&root, &buffers, None).unwrap();
        let tree = Arc::new(Tree::new(&root, motions, DAffine3::IDENTITY).unwrap());
        let mut compared = 0;
        for row in rows.iter().filter(|row| row[0] == name) {
            let numbers: Vec<f64> = row[1..].iter().map(|number| number.parse().unwrap()).collect();
            let [node, time, vertex, x, y, z] = numbers[..] else { panic!("six numbers: {row:?}") };
            let mesh = root.nodes[node as usize].mesh.unwrap().value();
            let key = Checked::Valid(gltf_json::mesh::Semantic::Positions);
            let positions = root.meshes[mesh].primitives[0].attributes[&key].value();
            let positions = Elements::<3>::new(&root, &buffers, positions, "positions").unwrap();
            let corner = DVec3::from_array(positions.get(vertex as usize).unwrap());
            let found = tree.pose(node as usize)(time).transform_point3(corner);
            assert!(found.distance(DVec3::new(x, y, z)) < 2e-5, "{row:?}: {found}");
            compared += 1;
        }
        assert!(compared >= 30, "{name}: {compared}");
    }
}

#[test]
fn what_never_moves_is_static() {
    let Some(path) = file("yard") else { return };
    let (model, loader) = load(&path);
    // The arm, the hand, the finger and the flag move; the node that is held does not.
    let moving: Vec<_> = model.moving.iter().map(|(geometry, _)| geometry.len()).collect();
    assert_eq!((model.statics.len(), moving), (12 + 12 + 7 + 12, vec![5, 12, 7, 7]));
    assert_eq!(model.cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>(), ["eye"]);
    let camera = model.cameras[0].at(1.0);
    assert_eq!((camera.eye, camera.forward, camera.up), (DVec3::new(0.0, 2.0, 12.0), DVec3::NEG_Z, DVec3::Y));
    let light = &model.lights[0];
    assert_eq!((light.color, light.moves), (Vec3::new(2.0, 1.0, 0.5), false));
    assert_eq!((light.pose)(1.0).translation, DVec3::new(0.0, 6.0, 0.0));
    let glass = loader.materials.iter().find(|material| material.transmittance > 0.0).unwrap();
    assert_eq!((glass.transmittance, glass.diffuse), (0.75, Vec3::ONE));
    let (.., origin) = loader.finish();
    assert_eq!(origin.notices, ["yard.gltf: the animation holds 1 nodes in one pose: they are static"]);
    assert_eq!(origin.sources.len(), 2);
}

#[test]
fn a_container_holds_the_same() {
    let Some(path) = file("yard") else { return };
    let (text, binary) = (load(&path).0, load(&path.with_extension("glb")).0);
    assert_eq!(text.statics, binary.statics);
    assert_eq!(text.moving.len(), binary.moving.len());
}

/// A triangle below a node, with its bytes in a data URI.
fn document() -> Value {
    let corners = [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|number| number.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 3]);
    json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "leaf"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 4}],
        "buffers": [{"byteLength": 52, "uri": format!("data:;base64,{}", STANDARD.encode(bytes))}],
    })
}

fn parsed(document: &Value, animation: Option<&str>) -> Result<(Model, Loader), String> {
    let mut loader = Loader::default();
    loader.add_material(Material::default());
    let bytes = serde_json::to_vec(document).unwrap();
    let model = parse(Path::new("x.gltf"), &bytes, animation, MaterialId(0), DAffine3::IDENTITY, &mut loader)?;
    Ok((model, loader))
}

/// The error with `value` at a JSON pointer of the document.
fn error(pointer: &str, value: Value) -> String {
    let mut document = document();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Object(map) => drop(map.insert(key.into(), value)),
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        _ => panic!("{pointer} leads nowhere"),
    }
    parsed(&document, None).map(|_| ()).expect_err(pointer)
}

#[test]
fn strips_and_fans_become_triangles() {
    let mut document = document();
    assert_eq!(parsed(&document, None).unwrap().0.statics.len(), 1);
    document["accessors"][1]["count"] = json!(4);
    for (mode, second) in
        [(5, [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y]), (6, [Vec3::ZERO, Vec3::Y, Vec3::new(1.0, 1.0, 0.0)])]
    {
        document["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let statics = parsed(&document, None).unwrap().0.statics;
        assert_eq!((statics.len(), statics.triangles[1].v), (2, second), "mode {mode}");
    }
    document["meshes"][0]["primitives"][0]["mode"] = json!(1);
    assert_eq!(parsed(&document, None).unwrap().0.statics.len(), 0, "lines have no area");
}

#[test]
fn what_breaks_the_specification_or_is_not_read_is_refused() {
    for (pointer, value, expected) in [
        ("/nodes/0", json!({"mesh": 0, "children": [0]}), "is below itself"),
        ("/nodes/0", json!({"mesh": 7}), "Index out of bounds"),
        ("/nodes/0", json!({"mesh": 0, "scale": [1e30, 1, 1]}), "a scale of"),
        (
            "/nodes/0",
            json!({"mesh": 0, "scale": [1e9, 1, 1], "translation": [1e9, 0, 0]}),
            "at most 1e9 from the origin",
        ),
        ("/nodes/0", json!({"mesh": 0, "rotation": [0, 0, 0, 2]}), "a quaternion of length 1"),
        ("/nodes/0", json!({"mesh": 0, "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}), "last row"),
        ("/scenes/0", json!({"nodes": [0, 0]}), "two parents"),
        ("/scenes", json!([]), "no scene"),
        ("/meshes/0/primitives/0/targets", json!([{"POSITION": 0}]), "morph targets"),
        ("/meshes/0/primitives/0/indices", json!(0), "elements are of 3 numbers: 1"),
        ("/accessors/0/count", json!(5), "not within buffer view 0"),
        ("/accessors/0/count", json!(2), "a position 2 is asked for, and there are 2"),
        ("/accessors/0/byteOffset", json!(u64::MAX), "not within buffer view 0"),
        ("/accessors/0/componentType", json!(5123), "not of floats"),
        ("/accessors/1/componentType", json!(5126), "not within buffer view 1"),
        ("/accessors/1/count", json!(2), "2 corners make no whole triangles"),
        ("/bufferViews/0/byteOffset", json!(8), "buffer view 0 is not within its buffer"),
        ("/bufferViews/0/byteLength", json!(u64::MAX), "buffer view 0 is not within its buffer"),
        ("/bufferViews/0/byteStride", json!(4), "not within buffer view 0"),
        ("/buffers/0/byteLength", json!(60), "buffer 0 has 52 bytes: 60 are told"),
        ("/buffers/0/uri", json!("absent.bin"), "buffer 0: cannot read absent.bin"),
        ("/buffers/0/uri", json!("https://a.b/c.bin"), "not relative"),
        ("/buffers/0", json!({"byteLength": 52}), "buffer 0 has no URI"),
        ("/asset/version", json!("1.0"), "glTF version"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "KHR_draco_mesh_compression, which changes"),
        ("/extensionsRequired", json!(["KHR_mesh_quantization"]), "KHR_mesh_quantization"),
        ("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"]), "EXT_mesh_gpu_instancing"),
    ] {
        let found = error(pointer, value);
        assert!(found.contains(expected), "{pointer}: {found}");
    }
    let mut skinned = document();
    skinned["skins"] = json!([{"joints": [0]}]);
    skinned["nodes"][0]["skin"] = json!(0);
    assert_eq!(parsed(&skinned, None).map(|_| ()).unwrap_err(), "node 0 (\"leaf\") has a skin: skins are not read");
    let mut told = document();
    told["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    let notices = parsed(&told, None).unwrap().1.finish().2.notices;
    assert_eq!(notices, ["x.gltf: 1 kind of statements has no effect: `extension KHR_materials_unlit` (1)"]);
}

#[test]
fn pictures_are_read_or_left_out() {
    let mut textured = document();
    textured["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    textured["textures"] = json!([{"source": 0}]);
    textured["images"] = json!([{"uri": "absent.png"}]);
    textured["meshes"][0]["primitives"][0]["material"] = json!(0);
    let missing = parsed(&textured, None).map(|_| ()).unwrap_err();
    assert!(missing.contains("cannot read absent.png") && missing.contains("`textures: Ignore`"), "{missing}");
    textured["images"][0]["uri"] = json!(format!("data:image/x;base64,{}", STANDARD.encode("P6 1 1 255\nabc")));
    let without_uv = parsed(&textured, None).map(|_| ()).unwrap_err();
    assert!(without_uv.contains("no TEXCOORD_0"), "{without_uv}");
    textured["accessors"][1]["count"] = json!(3);
    textured["accessors"].as_array_mut().unwrap().push(json!({"componentType": 5126, "count": 4, "type": "VEC2",
        "bufferView": 0}));
    textured["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(2);
    let (model, loader) = parsed(&textured, None).unwrap();
    assert_eq!(loader.textures[0].rgb, [*b"abc"]);
    // The second element is (0, 1): glTF counts v from the top.
    assert_eq!(model.statics.attributes[0].uv[1], glam::Vec2::new(0.0, 0.0));
}

#[test]
fn animations_are_chosen_by_name() {
    let mut moved = document();
    moved["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({"bufferView": 1, "byteOffset": 0, "componentType": 5121, "count": 2, "type": "SCALAR"}));
    let animation = |name: &str| {
        json!({"name": name, "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": 2, "output": 0}]})
    };
    moved["animations"] = json!([animation("a"), animation("b")]);
    let error = |document: &Value, name| parsed(document, name).map(|_| ()).unwrap_err();
    assert!(error(&moved, None).contains("must name one of \"a\", \"b\""));
    assert!(error(&moved, Some("c")).contains("no animation is named \"c\""));
    assert!(error(&moved, Some("a")).contains("2 keys and 4 values"));
    moved["animations"][0]["channels"][0]["sampler"] = json!(9);
    assert!(parsed(&moved, Some("a")).is_err());
    moved["animations"][0]["channels"][0] = json!({"sampler": 0, "target": {"node": 0, "path": "weights"}});
    assert!(error(&moved, Some("a")).contains("morph targets are not read"));
    moved["accessors"][2]["count"] = json!(4);
    let model = parsed(&moved, Some("b")).unwrap().0;
    assert_eq!((model.statics.len(), model.moving.len()), (0, 1));
    // Keys at 0, 1, 2 and 3 s.
    let positions = [-1.0, 0.5, 1.0, 1.5, 9.0].map(|time| (model.moving[0].1)(time).translation.truncate());
    assert_eq!(positions.map(|at| at.to_array()), [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.5, 0.5], [1.0, 1.0]]);
}
