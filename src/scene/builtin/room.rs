//! A furnished room with lamps, in which a toy train runs. Metres; the floor is at height 0.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec3, dvec3, vec3};

use super::made::Made;
use super::paint::{Palette, share};
use super::shapes::{Shapes, hash};
use crate::scene::camera::Camera;
use crate::scene::material::MaterialId;
use crate::scene::parts::{Part, Parts};

/// Half the width, the height, and half the depth of the room.
const ROOM: DVec3 = dvec3(3.0, 2.7, 2.5);
/// The middle of the rails.
const RAILS: DVec3 = dvec3(0.75, 0.02, 0.55);
/// The radius of the rails.
const LOOP: f64 = 0.85;
/// Metres that the train drives per frame: 0.6 m/s at 30 frames a second.
const DRIVE: f64 = 0.02;
/// The middle of the table.
const TABLE: DVec3 = dvec3(-1.5, 0.0, -0.6);

/// Places and colours of the lamps, in the order in which they are switched on.
const LAMPS: [(Vec3, Vec3); 6] = [
    (vec3(0.9, 2.5, 0.9), vec3(1.0, 0.95, 0.88)),
    (vec3(-1.5, 1.72, -0.6), vec3(1.0, 0.85, 0.65)),
    (vec3(-2.55, 1.55, -2.05), vec3(1.0, 0.8, 0.55)),
    (vec3(2.45, 1.2, -2.15), vec3(1.0, 0.8, 0.6)),
    (vec3(-1.5, 2.5, 1.5), vec3(1.0, 0.95, 0.88)),
    (vec3(2.0, 2.5, -1.2), vec3(1.0, 0.95, 0.88)),
];

/// Builds the room; a larger `detail` gives smaller tiles and more segments of round shapes.
pub(super) fn build(lights: usize, detail: usize) -> Made {
    let mut palette = Palette::default();
    let mut room = Maker { shapes: Shapes::default(), tile: 0.8 / detail as f64, round: 6 * detail };
    room.shell(&mut palette);
    room.window(&mut palette);
    room.table(&mut palette);
    room.shelves(&mut palette);
    room.lamps(&mut palette);
    room.comfort(&mut palette);
    let parts = train(&mut palette, 2 * detail.max(2));
    let camera = |frame: u32| {
        // A slow sway, as of a visitor who looks around.
        let t = f64::from(frame) * 0.02;
        let eye = dvec3(2.55 + 0.15 * t.cos(), 1.55 + 0.05 * (1.3 * t).sin(), 2.1 + 0.2 * t.sin());
        Camera::perspective(eye, dvec3(-0.4, 0.62, -0.6) - eye, DVec3::Y, 62f64.to_radians())
    };
    Made {
        statics: room.shapes.geometry,
        parts: Parts { parts, lights: share(&LAMPS, lights, 1.15), carried: Vec::new(), camera: Box::new(camera) },
        palette,
        background: vec3(0.55, 0.7, 0.9),
        ambient: Vec3::splat(0.2),
    }
}

struct Maker {
    shapes: Shapes,
    tile: f64,
    round: usize,
}

impl Maker {
    fn cuboid(&mut self, low: DVec3, size: DVec3) {
        self.shapes.cuboid(low, low + size, self.tile);
    }

    /// Floor, ceiling and walls; the left wall has a hole for the window.
    fn shell(&mut self, palette: &mut Palette) {
        let (floor, ceiling) =
            (palette.checker(4, [[176, 126, 80], [150, 100, 60]], 0.06), palette.matt(0.92, 0.91, 0.88));
        let (wall, accent) = (palette.matt(0.84, 0.8, 0.7), palette.matt(0.42, 0.55, 0.56));
        let (w, h, d) = (DVec3::X * 2.0 * ROOM.x, DVec3::Y * ROOM.y, DVec3::Z * 2.0 * ROOM.z);
        let low = dvec3(-ROOM.x, 0.0, -ROOM.z);
        let (tile, shapes) = (self.tile, &mut self.shapes);
        shapes.paint(floor).plane(low, d, w, tile);
        shapes.paint(ceiling).plane(low + h, w, d, tile);
        shapes.paint(accent).plane(low, w, h, tile);
        shapes.paint(wall).plane(low + d, h, w, tile);
        shapes.plane(low + w, d, h, tile);
        let (sill, head, near, far) = (Y * 0.9, Y * 2.2, DVec3::Z * 1.4, DVec3::Z * 3.4);
        shapes.plane(low, sill, d, tile);
        shapes.plane(low + head, h - head, d, tile);
        shapes.plane(low + sill, head - sill, near, tile);
        shapes.plane(low + sill + far, head - sill, d - far, tile);
        let skirting = palette.matt(0.93, 0.92, 0.9);
        self.shapes.paint(skirting);
        self.cuboid(low, dvec3(6.0, 0.09, 0.015));
        self.cuboid(low, dvec3(0.015, 0.09, 5.0));
        self.cuboid(low + w - DVec3::X * 0.015, dvec3(0.015, 0.09, 5.0));
    }

    fn window(&mut self, palette: &mut Palette) {
        let frame = palette.matt(0.95, 0.95, 0.93);
        self.shapes.paint(frame);
        let low = dvec3(-3.06, 0.9, -1.1);
        for z in [0.0, 0.96, 1.92] {
            self.cuboid(low + DVec3::Z * z, dvec3(0.08, 1.3, 0.08));
        }
        for y in [0.0, 0.82, 1.22] {
            self.cuboid(low + Y * y, dvec3(0.08, 0.08, 2.0));
        }
        self.cuboid(low + dvec3(0.0, -0.04, -0.05), dvec3(0.25, 0.04, 2.1));
        let (pot, leaf) = (palette.matt(0.72, 0.36, 0.22), palette.matt(0.22, 0.5, 0.18));
        self.shapes.paint(pot).column(dvec3(-2.92, 0.9, 0.5), [0.06, 0.09], 0.14, self.round);
        self.leaves(leaf, dvec3(-2.9, 1.05, 0.5), 0.26, 8 * self.round);
    }

    /// Leaves on curved stalks out of a pot.
    fn leaves(&mut self, leaf: MaterialId, root: DVec3, length: f64, count: usize) {
        self.shapes.paint(leaf);
        for i in 0..count as u64 {
            let turn = DQuat::from_rotation_y(TAU * hash(3 * i));
            let (rise, reach) = (0.4 + 0.6 * hash(3 * i + 1), length * (0.5 + 0.5 * hash(3 * i + 2)));
            let at = |s: f64, side: f64| {
                root + turn * dvec3(reach * s, reach * rise * s * (2.2 - 1.2 * s), 0.1 * reach * side)
            };
            let corners = [at(0.0, 0.0), at(0.6, -1.0), at(1.0, 0.0), at(0.6, 1.0)];
            self.shapes.triangle([corners[0], corners[1], corners[3]]);
            self.shapes.triangle([corners[1], corners[2], corners[3]]);
        }
    }

    /// A laid table with four chairs.
    fn table(&mut self, palette: &mut Palette) {
        let (wood, dark) = (palette.glossy(0.55, 0.33, 0.17), palette.matt(0.32, 0.19, 0.1));
        let (china, glass, fruit) = (palette.glossy(0.9, 0.9, 0.92), palette.glass(), palette.glossy(0.75, 0.2, 0.12));
        self.shapes.place(TABLE, 0.0).paint(wood);
        self.cuboid(dvec3(-0.8, 0.72, -0.45), dvec3(1.6, 0.04, 0.9));
        for (x, z) in [(-0.72, -0.37), (0.72, -0.37), (-0.72, 0.37), (0.72, 0.37)] {
            self.shapes.column(dvec3(x, 0.0, z), [0.025, 0.04], 0.72, self.round);
        }
        let bowl = [
            (0.0, 0.0),
            (0.06, 0.0),
            (0.06, 0.01),
            (0.13, 0.05),
            (0.17, 0.11),
            (0.16, 0.11),
            (0.12, 0.06),
            (0.0, 0.03),
        ];
        let round = self.round;
        self.shapes.paint(china).shifted(dvec3(0.1, 0.76, 0.0), |s| s.lathe(&bowl.map(DVec2::from), 2 * round));
        self.shapes.paint(fruit);
        for (x, y, z) in [(0.04, 0.85, 0.03), (0.15, 0.85, 0.05), (0.1, 0.85, -0.06), (0.1, 0.91, 0.01)] {
            self.shapes.sphere(dvec3(x, y, z), 0.052, round);
        }
        let vase = [(0.0, 0.0), (0.05, 0.0), (0.075, 0.06), (0.06, 0.16), (0.03, 0.23), (0.045, 0.28)];
        self.shapes.paint(glass).shifted(dvec3(-0.35, 0.76, -0.05), |s| s.lathe(&vase.map(DVec2::from), 2 * round));
        let plate = [(0.0, 0.0), (0.07, 0.0), (0.12, 0.018), (0.115, 0.02), (0.07, 0.006), (0.0, 0.006)];
        let cup = [(0.0, 0.0), (0.025, 0.0), (0.04, 0.04), (0.042, 0.08), (0.038, 0.08), (0.034, 0.04), (0.0, 0.01)];
        self.shapes.paint(china);
        for (x, z) in [(-0.4, 0.28), (0.4, 0.28), (-0.4, -0.28), (0.4, -0.28)] {
            self.shapes.shifted(dvec3(x, 0.76, z), |s| s.lathe(&plate.map(DVec2::from), 2 * round));
            self.shapes.shifted(dvec3(x + 0.18, 0.76, z), |s| s.lathe(&cup.map(DVec2::from), round));
        }
        for (x, z, turn) in [(-0.4, 0.62, 8.0), (0.45, 0.68, -12.0), (-0.4, -0.62, 180.0), (0.4, -0.6, 174.0)] {
            self.shapes.place(TABLE + dvec3(x, 0.0, z), turn).paint(dark);
            self.cuboid(dvec3(-0.21, 0.43, -0.21), dvec3(0.42, 0.04, 0.42));
            for (x, z) in [(-0.18, -0.18), (0.18, -0.18), (-0.18, 0.18), (0.18, 0.18)] {
                self.shapes.column(dvec3(x, 0.0, z), [0.015, 0.02], 0.43, self.round / 2);
            }
            for x in [-0.19, 0.16] {
                self.cuboid(dvec3(x, 0.47, 0.18), dvec3(0.03, 0.45, 0.03));
            }
            for y in [0.6, 0.72, 0.84] {
                self.cuboid(dvec3(-0.16, y, 0.187), dvec3(0.32, 0.06, 0.015));
            }
        }
        self.shapes.place(DVec3::ZERO, 0.0);
    }

    /// A book case against the back wall, and a mirror beside it.
    fn shelves(&mut self, palette: &mut Palette) {
        let wood = palette.matt(0.5, 0.34, 0.2);
        let books = [(0.62, 0.14, 0.12), (0.15, 0.28, 0.5), (0.2, 0.42, 0.25), (0.8, 0.62, 0.22), (0.85, 0.82, 0.74)]
            .map(|(r, g, b)| palette.matt(r, g, b));
        let low = dvec3(0.3, 0.0, -2.5);
        self.shapes.paint(wood);
        for x in [0.0, 1.37] {
            self.cuboid(low + DVec3::X * x, dvec3(0.03, 1.9, 0.3));
        }
        for shelf in 0..6 {
            self.cuboid(low + dvec3(0.03, 0.06 + 0.36 * f64::from(shelf), 0.0), dvec3(1.34, 0.025, 0.3));
        }
        let mut seed = 1000;
        let mut next = || {
            seed += 1;
            hash(seed)
        };
        for shelf in 0..5 {
            let (mut x, end) = (0.05, 0.7 + 0.6 * next());
            while x < end {
                let size = dvec3(0.02 + 0.03 * next(), 0.2 + 0.11 * next(), 0.16 + 0.06 * next());
                self.shapes.paint(books[(next() * 5.0) as usize]);
                self.cuboid(low + dvec3(x, 0.085 + 0.36 * f64::from(shelf), 0.04), size);
                x += size.x + 0.003;
            }
        }
        let ball = palette.glossy(0.2, 0.45, 0.7);
        self.shapes.paint(ball).sphere(low + dvec3(1.25, 0.085 + 0.36 * 2.0 + 0.08, 0.16), 0.08, self.round);
        let (mirror, frame) = (palette.mirror(), palette.glossy(0.65, 0.5, 0.2));
        let (low, tile) = (dvec3(-1.9, 1.05, -2.48), self.tile);
        self.shapes.paint(mirror).plane(low, DVec3::X * 1.3, Y * 0.95, tile);
        self.shapes.paint(frame);
        for y in [-0.05, 0.95] {
            self.cuboid(low + dvec3(-0.05, y, -0.02), dvec3(1.4, 0.05, 0.05));
        }
        for x in [-0.05, 1.3] {
            self.cuboid(low + dvec3(x, 0.0, -0.02), dvec3(0.05, 0.95, 0.05));
        }
    }

    /// The bodies of the six lamps; no body encloses its light.
    fn lamps(&mut self, palette: &mut Palette) {
        let (brass, shade, glow) =
            (palette.glossy(0.6, 0.48, 0.25), palette.matt(0.9, 0.78, 0.6), palette.glow(1.0, 0.9, 0.7));
        let (tile, round) = (0.02, self.round);
        // Spots in the ceiling: a rim around a disc.
        for lamp in [0, 4, 5] {
            let at = LAMPS[lamp].0.as_dvec3().with_y(ROOM.y);
            self.shapes.paint(brass).torus(at, 0.1, 0.02, [round, round / 2]);
            self.shapes.paint(glow).column(at - Y * 0.01, [0.09, 0.09], 0.01, round);
        }
        let pendant = LAMPS[1].0.as_dvec3();
        self.shapes.paint(brass).column(pendant + Y * 0.2, [0.008, 0.008], 0.78, 8);
        let cone = [(0.24, 0.03), (0.2, 0.1), (0.12, 0.17), (0.03, 0.2)].map(DVec2::from);
        self.shapes.paint(shade).shifted(pendant, |s| s.lathe(&cone, 2 * round));
        self.shapes.paint(glow).sphere(pendant + Y * 0.08, 0.05, round);
        let standing = [(LAMPS[2].0.as_dvec3().with_y(0.0), 1.4, 0.2), (LAMPS[3].0.as_dvec3().with_y(0.7), 0.35, 0.13)];
        for (foot, height, width) in standing {
            self.shapes.paint(brass).column(foot, [width * 0.7, width * 0.6], 0.03, 2 * round);
            self.shapes.column(foot, [0.012, 0.012], height, round);
            let drum = [(width, height - 0.05), (width * 0.75, height + 0.25)].map(DVec2::from);
            self.shapes.paint(shade).shifted(foot, |s| s.lathe(&drum, 2 * round));
        }
        // A small chest carries the last lamp.
        let chest = palette.matt(0.75, 0.73, 0.68);
        self.shapes.paint(chest).cuboid(dvec3(2.1, 0.05, -2.48), dvec3(2.9, 0.7, -2.0), self.tile);
        self.shapes.paint(brass);
        for y in [0.2, 0.42, 0.62] {
            self.shapes.cuboid(dvec3(2.4, y, -2.0), dvec3(2.6, y + 0.02, -1.98), tile);
        }
    }

    /// An armchair, the rug, and rails on it.
    fn comfort(&mut self, palette: &mut Palette) {
        let (cloth, rug) = (palette.matt(0.3, 0.42, 0.36), palette.checker(6, [[168, 52, 44], [222, 202, 168]], 0.0));
        let (steel, sleeper) = (palette.glossy(0.6, 0.62, 0.65), palette.matt(0.3, 0.2, 0.13));
        self.shapes.place(dvec3(2.2, 0.0, -1.1), -62.0).paint(cloth);
        self.cuboid(dvec3(-0.36, 0.12, -0.38), dvec3(0.72, 0.3, 0.76));
        self.cuboid(dvec3(-0.48, 0.08, -0.4), dvec3(0.12, 0.55, 0.8));
        self.cuboid(dvec3(0.36, 0.08, -0.4), dvec3(0.12, 0.55, 0.8));
        self.cuboid(dvec3(-0.48, 0.12, -0.55), dvec3(0.96, 0.85, 0.17));
        self.shapes.place(DVec3::ZERO, 0.0).paint(rug);
        self.cuboid(RAILS.with_y(0.001) + dvec3(-1.2, 0.0, -1.2), dvec3(2.4, 0.012, 2.4));
        self.shapes.paint(steel);
        for side in [-0.04, 0.04] {
            self.shapes.torus(RAILS, LOOP + side, 0.006, [4 * self.round, 6]);
        }
        self.shapes.paint(sleeper);
        for i in 0..2 * self.round {
            let turn = 180.0 * i as f64 / self.round as f64;
            self.shapes.place(RAILS, turn);
            self.cuboid(dvec3(LOOP - 0.07, -0.008, -0.012), dvec3(0.14, 0.006, 0.024));
        }
        self.shapes.place(DVec3::ZERO, 0.0);
    }
}

const Y: DVec3 = DVec3::Y;

/// The engine and three wagons, one behind the other on the rails.
fn train(palette: &mut Palette, round: usize) -> Vec<Part> {
    let (red, black, brass) =
        (palette.glossy(0.75, 0.1, 0.08), palette.glossy(0.08, 0.08, 0.09), palette.glossy(0.8, 0.6, 0.2));
    let mut carriages = vec![engine(red, black, brass, round)];
    for (r, g, b) in [(0.15, 0.35, 0.65), (0.85, 0.65, 0.15), (0.2, 0.5, 0.25)] {
        let paint = palette.glossy(r, g, b);
        carriages.push(wagon(paint, black, brass, round));
    }
    let place = |index: usize| {
        move |frame: u32| {
            let angle = (f64::from(frame) * DRIVE - 0.3 * index as f64) / LOOP;
            let heading = DQuat::from_rotation_y(-(angle + FRAC_PI_2));
            DAffine3::from_rotation_translation(heading, RAILS + dvec3(LOOP * angle.cos(), 0.006, LOOP * angle.sin()))
        }
    };
    let parts = carriages.into_iter().enumerate();
    parts.map(|(index, shapes)| Part { geometry: shapes.geometry, pose: Box::new(place(index)) }).collect()
}

/// Turns upright shapes so that they lie along the direction of travel (`along`) or across it.
fn lying(shapes: &mut Shapes, origin: DVec3, along: bool) {
    let turn = if along { DQuat::from_rotation_z(-FRAC_PI_2) } else { DQuat::from_rotation_x(FRAC_PI_2) };
    shapes.at = DAffine3::from_rotation_translation(turn, origin);
}

fn wheels(shapes: &mut Shapes, paint: MaterialId, at: &[f64], radius: f64, round: usize) {
    shapes.paint(paint);
    for x in at {
        for z in [-0.052, 0.04] {
            lying(shapes, dvec3(*x, radius, z), false);
            shapes.column(DVec3::ZERO, [radius, radius], 0.012, round);
        }
    }
    shapes.at = DAffine3::IDENTITY;
}

fn engine(red: MaterialId, black: MaterialId, brass: MaterialId, round: usize) -> Shapes {
    let mut shapes = Shapes::default();
    wheels(&mut shapes, red, &[-0.08, 0.0, 0.08], 0.03, round);
    shapes.paint(black).cuboid(dvec3(-0.13, 0.04, -0.04), dvec3(0.13, 0.06, 0.04), 1.0);
    lying(&mut shapes, dvec3(-0.05, 0.1, 0.0), true);
    shapes.paint(red).column(DVec3::ZERO, [0.042, 0.042], 0.17, 2 * round);
    shapes.paint(black).column(Y * 0.17, [0.044, 0.035], 0.015, 2 * round);
    shapes.at = DAffine3::IDENTITY;
    shapes.column(dvec3(0.09, 0.13, 0.0), [0.012, 0.022], 0.07, round);
    shapes.paint(brass).sphere(dvec3(0.02, 0.14, 0.0), 0.022, round);
    shapes.paint(red).cuboid(dvec3(-0.13, 0.06, -0.045), dvec3(-0.05, 0.17, 0.045), 1.0);
    shapes.paint(black).cuboid(dvec3(-0.14, 0.17, -0.055), dvec3(-0.04, 0.18, 0.055), 1.0);
    shapes
}

fn wagon(paint: MaterialId, black: MaterialId, brass: MaterialId, round: usize) -> Shapes {
    let mut shapes = Shapes::default();
    wheels(&mut shapes, black, &[-0.07, 0.07], 0.025, round);
    shapes.paint(black).cuboid(dvec3(-0.12, 0.035, -0.04), dvec3(0.12, 0.05, 0.04), 1.0);
    shapes.cuboid(dvec3(0.12, 0.035, -0.006), dvec3(0.19, 0.042, 0.006), 1.0);
    shapes.paint(paint);
    for (low, high) in [
        (dvec3(-0.12, 0.05, -0.05), dvec3(0.12, 0.11, -0.042)),
        (dvec3(-0.12, 0.05, 0.042), dvec3(0.12, 0.11, 0.05)),
        (dvec3(-0.12, 0.05, -0.042), dvec3(-0.112, 0.11, 0.042)),
        (dvec3(0.112, 0.05, -0.042), dvec3(0.12, 0.11, 0.042)),
    ] {
        shapes.cuboid(low, high, 1.0);
    }
    shapes.paint(brass);
    for (x, z) in [(-0.07, 0.01), (0.0, -0.01), (0.06, 0.012)] {
        shapes.sphere(dvec3(x, 0.1, z), 0.034, round);
    }
    shapes
}
