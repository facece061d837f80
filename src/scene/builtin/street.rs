//! A street of houses and trees at dusk, with people walking. Metres; it runs from the origin towards -z.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3, dvec3, vec3};

use super::made::Made;
use super::paint::{Palette, share};
use super::shapes::{Shapes, hash};
use crate::scene::camera::Camera;
use crate::scene::material::MaterialId;
use crate::scene::parts::{Part, Parts, Pose};

/// Metres from one house to the next.
const PLOT: f64 = 9.0;
/// Half the width of the road, and the distance from its middle to the houses.
const ROAD: f64 = 3.0;
const FRONT: f64 = 6.6;
/// Metres per frame that people walk, and that the camera drives at most: 1.4 m/s and 3 m/s at 30 frames a second.
const WALK: f64 = 0.047;
const DRIVE: f64 = 0.1;
/// Edge of a tile of a wall or of the road.
const TILE: f64 = 0.75;

/// The street; its length follows from the number of houses.
pub(super) fn build(lights: usize, houses: usize, walkers: usize) -> Made {
    let mut palette = Palette::default();
    let length = houses as f64 * PLOT;
    let mut shapes = Shapes::default();
    ground(&mut shapes, &mut palette, length);
    let looks = Looks::new(&mut palette);
    for i in 0..houses {
        let z = -PLOT * (i as f64 + 0.5);
        for (side, turn) in [(-1.0, 90.0), (1.0, -90.0)] {
            let seed = 10_000 + 20 * (2 * i as u64 + u64::from(side > 0.0));
            shapes.place(dvec3(side * FRONT, 0.12, z), turn);
            house(&mut shapes, &looks, seed);
            shapes.place(dvec3(side * (ROAD + 0.9), 0.12, z + 0.5 * PLOT - 1.0), 360.0 * hash(seed));
            tree(&mut shapes, &looks, seed);
        }
    }
    // One house looks down the street.
    shapes.place(dvec3(0.0, 0.0, -length - 4.0), 0.0);
    house(&mut shapes, &looks, 9_260);
    let lamps = lamps(&mut shapes, &mut palette, length);
    shelter(&mut shapes, &mut palette);

    let parts = (0..walkers).flat_map(|i| walker(&mut palette, i as u64, length)).collect();
    // There and back again, slow at both ends; the first frame is a little after the turn.
    let reach = 0.5 * length;
    let camera = move |frame: u32| {
        let phase = 0.5 + f64::from(frame) * 2.0 * DRIVE / reach;
        let eye = dvec3(0.9 + 0.2 * (1.7 * phase).sin(), 1.75, 1.0 - 0.5 * reach * (1.0 - phase.cos()));
        Camera::perspective(eye, dvec3(-0.12, 0.06, -1.0), DVec3::Y, 55f64.to_radians())
    };
    Made {
        statics: shapes.geometry,
        parts: Parts { parts, lights: share(&lamps, lights, 1.25), carried: Vec::new(), camera: Box::new(camera) },
        palette,
        background: vec3(0.36, 0.42, 0.6),
        ambient: vec3(0.24, 0.25, 0.32),
    }
}

/// Materials that are used often.
struct Looks {
    walls: [MaterialId; 6],
    roofs: [MaterialId; 2],
    trim: MaterialId,
    door: MaterialId,
    pane: MaterialId,
    lit: MaterialId,
    bark: MaterialId,
    leaves: [MaterialId; 3],
}

impl Looks {
    fn new(palette: &mut Palette) -> Self {
        let walls = [
            (0.78, 0.7, 0.56),
            (0.7, 0.42, 0.33),
            (0.62, 0.66, 0.62),
            (0.82, 0.76, 0.7),
            (0.55, 0.62, 0.72),
            (0.76, 0.6, 0.42),
        ];
        let pane = palette.mirror();
        palette.materials[pane.0 as usize].specular = vec3(0.45, 0.48, 0.52);
        Self {
            walls: walls.map(|(r, g, b)| palette.matt(r, g, b)),
            roofs: [palette.matt(0.45, 0.2, 0.15), palette.matt(0.25, 0.26, 0.3)],
            trim: palette.matt(0.9, 0.89, 0.85),
            door: palette.glossy(0.16, 0.28, 0.24),
            pane,
            lit: palette.glow(0.85, 0.65, 0.32),
            bark: palette.matt(0.3, 0.22, 0.15),
            leaves: [palette.matt(0.2, 0.42, 0.14), palette.matt(0.32, 0.5, 0.16), palette.matt(0.14, 0.34, 0.16)],
        }
    }
}

fn ground(shapes: &mut Shapes, palette: &mut Palette, length: f64) {
    let (asphalt, line) = (palette.matt(0.24, 0.24, 0.26), palette.matt(0.85, 0.84, 0.78));
    let (stone, curb) = (palette.checker(2, [[150, 144, 136], [128, 122, 116]], 0.0), palette.matt(0.6, 0.59, 0.57));
    let grass = palette.matt(0.24, 0.36, 0.16);
    let (start, whole) = (6.0, length + 8.0);
    let along = DVec3::Z * whole;
    let corner = |x: f64, y: f64| dvec3(x, y, start - whole);
    shapes.paint(asphalt).plane(corner(-ROAD, 0.0), along, DVec3::X * 2.0 * ROAD, TILE);
    for side in [-FRONT, ROAD + 0.15] {
        let width = FRONT - ROAD - 0.15;
        shapes.paint(stone).plane(corner(side, 0.12), along, DVec3::X * width, TILE);
    }
    for side in [-ROAD - 0.15, ROAD] {
        let low = corner(side, 0.0);
        shapes.paint(curb).cuboid(low, low + dvec3(0.15, 0.13, whole), TILE);
    }
    for side in [-FRONT - 30.0, FRONT] {
        shapes.paint(grass).plane(corner(side, 0.1), along, DVec3::X * 30.0, 2.0 * TILE);
    }
    shapes.plane(dvec3(-40.0, -0.01, start - whole - 40.0), DVec3::Z * 40.0, DVec3::X * 80.0, 4.0 * TILE);
    for dash in 0..(whole / 4.0) as u32 {
        let low = dvec3(-0.06, 0.004, start - 4.0 * f64::from(dash) - 2.0);
        shapes.paint(line).plane(low, DVec3::Z * 1.8, DVec3::X * 0.12, TILE);
    }
}

/// A house whose front faces +z with its middle at the origin.
fn house(shapes: &mut Shapes, looks: &Looks, seed: u64) {
    let storeys = 2 + (hash(seed + 1) * 1.6) as u32;
    let (half, depth, storey) = (4.1, 7.0, 2.8);
    let height = storey * f64::from(storeys) + 0.3;
    shapes.paint(looks.walls[(hash(seed + 2) * 6.0) as usize]);
    let (low, wide, deep, up) =
        (dvec3(-half, 0.0, 0.0), DVec3::X * 2.0 * half, DVec3::NEG_Z * depth, DVec3::Y * height);
    shapes.plane(low, wide, up, TILE);
    shapes.plane(low + wide, deep, up, TILE);
    shapes.plane(low + wide + deep, -wide, up, 2.0 * TILE);
    shapes.plane(low + deep, -deep, up, TILE);
    let ridge = dvec3(0.0, height + 1.9, -0.5 * depth);
    for side in [-half, half] {
        let gable = [dvec3(side, height, 0.0), dvec3(side, height, -depth), ridge.with_x(side)];
        shapes.triangle(if side > 0.0 { gable } else { [gable[1], gable[0], gable[2]] });
    }
    // The roof juts out a little, and its slopes meet at the ridge.
    shapes.paint(looks.roofs[(hash(seed + 3) * 2.0) as usize]);
    let slope = |z: f64| (dvec3(0.0, height, z) - ridge.with_x(0.0)) * 1.12;
    let (left, right) = (ridge.with_x(-half - 0.15), DVec3::X * (2.0 * half + 0.3));
    shapes.plane(left + slope(0.0), right, -slope(0.0), TILE);
    shapes.plane(left + right + slope(-depth), -right, -slope(-depth), TILE);
    let chimney = dvec3(1.6, height + 0.6, -0.35 * depth);
    shapes.paint(looks.roofs[0]).cuboid(chimney, chimney + dvec3(0.6, 1.7, 0.6), TILE);

    shapes.paint(looks.trim);
    for floor in 1..=storeys {
        let low = dvec3(-half, storey * f64::from(floor), 0.0);
        shapes.cuboid(low, low + dvec3(2.0 * half, 0.14, 0.1), TILE);
    }
    for floor in 0..storeys {
        for (column, x) in [-2.6, 0.0, 2.6].into_iter().enumerate() {
            let at = dvec3(x, storey * f64::from(floor), 0.0);
            if floor == 0 && column == 1 {
                door(shapes, looks, at);
            } else {
                let lit = hash(seed + 4 + u64::from(floor) * 3 + column as u64) < 0.3;
                window(shapes, looks, at + DVec3::Y * 0.85, lit);
            }
        }
    }
}

fn door(shapes: &mut Shapes, looks: &Looks, at: DVec3) {
    shapes.paint(looks.door).cuboid(at + dvec3(-0.5, 0.2, 0.0), at + dvec3(0.5, 2.3, 0.04), TILE);
    shapes.paint(looks.trim).cuboid(at + dvec3(-0.8, 0.0, 0.0), at + dvec3(0.8, 0.2, 0.5), TILE);
    shapes.cuboid(at + dvec3(-0.62, 0.2, 0.0), at + dvec3(-0.5, 2.42, 0.1), TILE);
    shapes.cuboid(at + dvec3(0.5, 0.2, 0.0), at + dvec3(0.62, 2.42, 0.1), TILE);
    shapes.cuboid(at + dvec3(-0.8, 2.42, 0.0), at + dvec3(0.8, 2.52, 0.6), TILE);
    shapes.paint(looks.lit).sphere(at + dvec3(0.42, 1.25, 0.07), 0.04, 8);
}

/// A window with a frame, a cross bar and a ledge, whose middle stands on `at`.
fn window(shapes: &mut Shapes, looks: &Looks, at: DVec3, lit: bool) {
    shapes.paint(if lit { looks.lit } else { looks.pane });
    shapes.plane(at + dvec3(-0.55, 0.0, 0.02), DVec3::X * 1.1, DVec3::Y * 1.35, TILE);
    shapes.paint(looks.trim);
    for x in [-0.62, -0.03, 0.55] {
        shapes.cuboid(at + dvec3(x, 0.0, 0.0), at + dvec3(x + 0.07, 1.35, 0.07), 2.0 * TILE);
    }
    for y in [0.85, 1.35] {
        shapes.cuboid(at + dvec3(-0.62, y, 0.0), at + dvec3(0.62, y + 0.07, 0.07), 2.0 * TILE);
    }
    shapes.cuboid(at + dvec3(-0.72, -0.08, 0.0), at + dvec3(0.72, 0.0, 0.22), TILE);
}

/// A tree: a trunk, some branches, and many loose leaves in a crown.
fn tree(shapes: &mut Shapes, looks: &Looks, seed: u64) {
    const LEAVES: u64 = 1_600;
    let crown = dvec3(0.0, 3.7 + 0.6 * hash(seed + 7), 0.0);
    let trunk = [(0.2, 0.0), (0.13, 0.4), (0.1, 1.5), (0.06, crown.y)].map(DVec2::from);
    shapes.paint(looks.bark).lathe(&trunk, 10);
    let place = shapes.at;
    for branch in 0..6 {
        let lean = DQuat::from_rotation_y(TAU * (f64::from(branch) / 6.0)) * DQuat::from_rotation_z(0.9);
        shapes.at = place * DAffine3::from_rotation_translation(lean, DVec3::Y * (2.2 + 0.25 * f64::from(branch)));
        shapes.column(DVec3::ZERO, [0.05, 0.015], 1.2, 6);
    }
    shapes.at = place;
    for leaf in 0..LEAVES {
        let mut next = seed.wrapping_mul(1 << 20) + 16 * leaf;
        let mut random = || {
            next += 1;
            hash(next)
        };
        // Most leaves are in the outer half of the crown.
        let direction = on_sphere(random(), random());
        let at = crown
            + direction * dvec3(1.35, 1.65, 1.35) * (0.85 + 0.3 * hash(seed + 8)) * (0.35 + 0.65 * random().sqrt());
        let turn = DQuat::from_axis_angle(on_sphere(random(), random()), TAU * random());
        let size = 0.14 + 0.1 * random();
        shapes.paint(looks.leaves[(random() * 3.0) as usize]);
        shapes.triangle([
            at - turn * DVec3::X * size * 0.5,
            at + turn * DVec3::X * size * 0.5,
            at + turn * DVec3::Y * size,
        ]);
    }
}

/// A point of the unit sphere from two numbers from 0 to 1; uniform numbers give uniform points.
fn on_sphere(s: f64, t: f64) -> DVec3 {
    let y = 2.0 * s - 1.0;
    let (sin, cos) = (TAU * t).sin_cos();
    let flat = (1.0 - y * y).sqrt();
    dvec3(flat * cos, y, flat * sin)
}

/// Six street lamps on alternate sides, spread over the first half of the street. Returns the positions and colours of
/// their lights.
fn lamps(shapes: &mut Shapes, palette: &mut Palette, length: f64) -> [(Vec3, Vec3); 6] {
    let (iron, glow) = (palette.glossy(0.16, 0.2, 0.19), palette.glow(1.0, 0.85, 0.55));
    let mut lights = [(Vec3::ZERO, vec3(1.0, 0.86, 0.62)); 6];
    for (i, light) in lights.iter_mut().enumerate() {
        let side = if i % 2 == 0 { -1.0 } else { 1.0 };
        let foot = dvec3(side * (ROAD + 0.35), 0.12, -2.5 - 0.12 * length * i as f64);
        shapes.place(foot, if side > 0.0 { 180.0 } else { 0.0 }).paint(iron);
        shapes.column(DVec3::ZERO, [0.14, 0.1], 0.5, 12);
        shapes.column(DVec3::Y * 0.5, [0.06, 0.045], 4.0, 12);
        shapes.cuboid(dvec3(-0.03, 4.45, -0.03), dvec3(1.2, 4.51, 0.03), TILE);
        let hood = [(0.28, 4.3), (0.24, 4.4), (0.06, 4.5), (0.0, 4.52)].map(DVec2::from);
        shapes.shifted(DVec3::X * 1.2, |shapes| shapes.lathe(&hood, 16));
        shapes.paint(glow).sphere(dvec3(1.2, 4.34, 0.0), 0.1, 12);
        // The light hangs just under the bulb, in the open.
        light.0 = (foot + dvec3(-side * 1.2, 4.2, 0.0)).as_vec3();
    }
    shapes.place(DVec3::ZERO, 0.0);
    lights
}

/// A bus shelter of glass at the right of the road.
fn shelter(shapes: &mut Shapes, palette: &mut Palette) {
    let (iron, glass, wood) = (palette.glossy(0.3, 0.32, 0.34), palette.glass(), palette.matt(0.5, 0.33, 0.18));
    shapes.place(dvec3(FRONT - 0.1, 0.12, -PLOT * 1.35), -90.0).paint(iron);
    for (x, z) in [(-1.5, 0.0), (1.5, 0.0), (-1.5, 1.1), (1.5, 1.1)] {
        shapes.column(dvec3(x, 0.0, z), [0.035, 0.035], 2.3, 10);
    }
    shapes.cuboid(dvec3(-1.65, 2.3, -0.1), dvec3(1.65, 2.38, 1.3), TILE);
    shapes.paint(glass).cuboid(dvec3(-1.45, 0.25, -0.01), dvec3(1.45, 2.1, 0.01), TILE);
    for x in [-1.51, 1.49] {
        shapes.cuboid(dvec3(x, 0.25, 0.05), dvec3(x + 0.02, 2.1, 1.05), TILE);
    }
    shapes.paint(wood).cuboid(dvec3(-1.2, 0.42, 0.1), dvec3(1.2, 0.47, 0.5), TILE);
    shapes.place(DVec3::ZERO, 0.0);
}

/// A person who walks along the street: trunk and head, and limbs of two parts each.
fn walker(palette: &mut Palette, index: u64, length: f64) -> Vec<Part> {
    let random = |what: u64| hash(500 + 10 * index + what);
    let coat =
        palette.matt(0.15 + 0.7 * random(0) as f32, 0.15 + 0.5 * random(1) as f32, 0.15 + 0.6 * random(2) as f32);
    let (cloth, skin) = (palette.matt(0.14, 0.16, 0.24), palette.matt(0.78, 0.56, 0.44));
    let dark = 0.1 + 0.4 * random(7) as f32;
    let dark = palette.matt(dark, 0.7 * dark, 0.4 * dark);
    let side = if index.is_multiple_of(2) { -1.0 } else { 1.0 };
    // One direction on each pavement, and some who walk the other way.
    let heading = if random(3) < 0.3 { -side } else { side };
    let x = side * (ROAD + 1.3 + random(4));
    let start = length * (0.3 * random(5) + 0.381_966 * index as f64).fract();
    let pace = WALK * (0.85 + 0.3 * random(6));
    let base = move |frame: u32| {
        let walked = (start + heading * pace * f64::from(frame)).rem_euclid(length);
        // Two steps a swing of the legs, of 0.75 m each.
        let phase = PI * walked * heading / 0.75;
        let turn = if heading > 0.0 { PI } else { 0.0 };
        let rise = 0.12 + 0.02 * (2.0 * phase).cos();
        (DAffine3::from_rotation_translation(DQuat::from_rotation_y(turn), dvec3(x, rise, -walked)), phase)
    };
    let body = |material: MaterialId, outline: &[(f64, f64)]| {
        let mut shapes = Shapes { material, ..Shapes::default() };
        let outline: Vec<DVec2> = outline.iter().copied().map(DVec2::from).collect();
        shapes.lathe(&outline, 12);
        shapes.geometry
    };
    let still = |y: f64| -> Pose { Box::new(move |frame| base(frame).0 * DAffine3::from_translation(DVec3::Y * y)) };
    let mut head = Shapes { material: skin, ..Shapes::default() };
    head.sphere(DVec3::Y * 0.13, 0.115, 14);
    let hair = [(0.122, 0.12), (0.118, 0.17), (0.08, 0.23), (0.0, 0.256)].map(DVec2::from);
    head.paint(dark).place(dvec3(0.0, 0.0, 0.012), 0.0).lathe(&hair, 14);
    head.place(DVec3::ZERO, 0.0).paint(skin).column(DVec3::Y * -0.06, [0.05, 0.05], 0.1, 10);
    let trunk =
        [(0.0, 0.0), (0.15, 0.02), (0.17, 0.12), (0.14, 0.3), (0.19, 0.5), (0.16, 0.58), (0.05, 0.62), (0.0, 0.62)];
    let mut parts = vec![
        Part { geometry: body(coat, &trunk), pose: still(0.86) },
        Part { geometry: head.geometry, pose: still(1.5) },
    ];
    for z in [-1.0, 1.0] {
        let limb = |at: DVec3, swing: f64, bend: f64, upper: f64| -> [Pose; 2] {
            let joint = move |frame: u32| {
                let (base, phase) = base(frame);
                let swung = DQuat::from_rotation_x(swing * z * phase.sin());
                (base * DAffine3::from_rotation_translation(swung, at), phase)
            };
            // A knee bends most while its leg swings forward; an elbow is held bent.
            let second = move |frame: u32| {
                let (joint, phase) = joint(frame);
                let bent = DQuat::from_rotation_x(bend * (0.55 + 0.45 * z * phase.cos()));
                joint * DAffine3::from_rotation_translation(bent, DVec3::Y * -upper)
            };
            [Box::new(move |frame| joint(frame).0), Box::new(second)]
        };
        let [thigh, shank] = limb(dvec3(0.09 * z, 0.9, 0.0), 0.5, -0.7, 0.43);
        let [arm, hand] = limb(dvec3(0.22 * z, 1.4, 0.0), -0.45, 0.6, 0.3);
        let leg = [(0.0, -0.45), (0.06, -0.44), (0.085, -0.02), (0.05, 0.05), (0.0, 0.06)];
        let foot = [(0.0, -0.44), (0.07, -0.43), (0.05, -0.36), (0.06, -0.05), (0.0, 0.02)];
        let sleeve = [(0.0, -0.32), (0.045, -0.3), (0.06, -0.02), (0.04, 0.04), (0.0, 0.05)];
        let fore = [(0.0, -0.33), (0.03, -0.31), (0.04, -0.02), (0.0, 0.02)];
        parts.push(Part { geometry: body(cloth, &leg), pose: thigh });
        parts.push(Part { geometry: body(cloth, &foot), pose: shank });
        parts.push(Part { geometry: body(coat, &sleeve), pose: arm });
        parts.push(Part { geometry: body(skin, &fore), pose: hand });
    }
    parts
}
