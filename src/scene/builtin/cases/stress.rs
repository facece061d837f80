//! Random small scenes, made by a recipe: ground, pieces that float above it, pieces that move, lights, a camera.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3, Vec3};

use super::film::{Film, MATT, MIRROR, palette};
use crate::random::GOLDEN;
use crate::scene::builtin::shapes::hash;
use crate::scene::camera::Camera;
use crate::scene::frame::{Frame, Origin, Scene};
use crate::scene::geometry::{Attributes, Geometry, Triangle};
use crate::scene::lamps::Lamps;
use crate::scene::lamps::rectangle;
use crate::scene::light::Light;
use crate::scene::material::MaterialId;

/// The recipe of a random scene. The ground is about ten units wide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Seed of the random numbers.
    pub seed: u64,
    /// The middle of the ground.
    pub centre: [f64; 3],
    /// Squares along a side of the ground; 0 for no ground.
    pub ground: u32,
    /// Floating triangles that stand still.
    pub count: u32,
    /// Their shape.
    pub pieces: Pieces,
    /// Triangles that move.
    pub moving: u32,
    /// Lights.
    pub lights: u32,
    /// Whether the lights move.
    pub lights_move: bool,
    /// Points along an edge of the first light if it is a rectangle; 0 for a point light.
    pub area: u32,
    /// The camera's motion.
    pub camera: CameraPath,
}

/// The shape of floating triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pieces {
    /// Of any shape.
    Any,
    /// Needles.
    Slivers,
    /// Every other triangle is a point or a line.
    Degenerate,
    /// In the plane of the ground; every other triangle exists twice.
    Coplanar,
}

/// The motion of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CameraPath {
    /// It stands still; its samples move within their pixels.
    Jitter,
    /// It moves by a fraction of a pixel to some pixels a frame.
    Pan,
    /// It has a new position in each frame.
    Jump,
}

impl Default for Recipe {
    fn default() -> Self {
        Self {
            seed: 0,
            centre: [0.0; 3],
            ground: 8,
            count: 30,
            pieces: Pieces::Any,
            moving: 6,
            lights: 2,
            lights_move: false,
            area: 0,
            camera: CameraPath::Pan,
        }
    }
}

/// Frames of every recipe.
const FRAMES: u32 = 8;

/// Random numbers, each selected by its purpose.
#[derive(Clone, Copy)]
struct Dice(u64);

impl Dice {
    fn part(self, what: u64) -> Self {
        Self((self.0 ^ what.wrapping_mul(GOLDEN)).wrapping_mul(0xbf58_476d_1ce4_e5b9).rotate_left(29))
    }

    /// From 0 to 1.
    fn share(self, what: u64) -> f64 {
        hash(self.part(what).0)
    }

    /// From -1 to 1 in each coordinate.
    fn cube(self, what: u64) -> DVec3 {
        let at = self.part(what);
        DVec3::from_array([0, 1, 2].map(|axis| 2.0 * at.share(axis) - 1.0))
    }
}

impl Recipe {
    /// The scene.
    pub fn scene(self, name: &str) -> Scene {
        Scene {
            name: name.into(),
            statics: self.statics(),
            dynamic_count: self.moving as usize,
            light_count: self.points().sum(),
            lamps: Lamps::of_sizes(self.points()),
            frame_count: FRAMES,
            materials: palette(),
            textures: Vec::new(),
            background: Vec3::splat(0.2),
            ambient: Vec3::ONE,
            origin: Origin::default(),
            animation: Box::new(Film(move |number| self.frame(number))),
        }
    }

    /// Points of each light.
    fn points(self) -> impl Iterator<Item = usize> {
        (0..self.lights).map(move |light| if light == 0 { self.area.max(1).pow(2) as usize } else { 1 })
    }

    fn dice(self, what: u64) -> Dice {
        Dice(self.seed).part(what)
    }

    fn statics(self) -> Geometry {
        let mut statics = Geometry::default();
        let side = 10.0 / f64::from(self.ground.max(1));
        for (x, y) in (0..self.ground).flat_map(|y| (0..self.ground).map(move |x| (x, y))) {
            let corner =
                |dx: u32, dy: u32| DVec3::new(f64::from(x + dx) * side - 5.0, 0.0, f64::from(y + dy) * side - 5.0);
            let [a, b, c, d] = [corner(0, 0), corner(0, 1), corner(1, 1), corner(1, 0)];
            self.push(&mut statics, [a, b, c], MATT);
            self.push(&mut statics, [a, c, d], MATT);
        }
        for piece in 0..u64::from(self.count) {
            let dice = self.dice(1).part(piece);
            let middle = dice.cube(0) * DVec3::new(4.0, 1.0, 4.0) + DVec3::Y * 1.5;
            let [a, b] = [dice.cube(1), dice.cube(2)];
            let odd = piece % 2 == 1;
            let corners = match self.pieces {
                Pieces::Any => [middle, middle + a, middle + b],
                Pieces::Slivers => [middle, middle + 3.0 * a, middle + 1.5 * a + 3e-4 * b],
                Pieces::Degenerate if odd => [middle, middle, middle + if piece % 4 == 1 { DVec3::ZERO } else { a }],
                Pieces::Degenerate => [middle, middle + a, middle + b],
                Pieces::Coplanar => [middle, middle + a, middle + b].map(|corner| corner.with_y(0.0)),
            };
            // Glass would add nothing: it blocks shadow rays like every material.
            let material = if piece % 5 == 4 { MIRROR } else { MATT };
            self.push(&mut statics, corners, material);
            if self.pieces == Pieces::Coplanar && odd {
                self.push(&mut statics, corners, material);
            }
        }
        statics
    }

    fn push(self, to: &mut Geometry, corners: [DVec3; 3], material: MaterialId) {
        let place = |corner: DVec3| (corner + DVec3::from_array(self.centre)).as_vec3();
        to.push(Triangle { v: corners.map(place) }, Attributes { material, ..Attributes::default() });
    }

    fn frame(self, number: u32) -> Frame {
        let time = f64::from(number);
        let mut dynamic = Geometry::default();
        let mut visible = Vec::new();
        for piece in 0..u64::from(self.moving) {
            let dice = self.dice(2).part(piece);
            let turn = DQuat::from_rotation_y(0.4 * time * (dice.share(9) - 0.3));
            let middle = turn * (dice.cube(0) * DVec3::new(4.0, 0.8, 4.0) + DVec3::Y * 2.0);
            self.push(&mut dynamic, [middle, middle + turn * dice.cube(1), middle + turn * dice.cube(2)], MATT);
            // Some are invisible in some frames.
            visible.push(piece % 3 != 2 || number % 3 != 1);
        }
        let lights = (0..u64::from(self.lights)).map(|light| {
            let dice = self.dice(3).part(light);
            let at = dice.cube(0) * DVec3::new(6.0, 1.5, 6.0) + DVec3::Y * 5.0;
            let moved = if self.lights_move { at + dice.cube(1) * (0.2 * time) } else { at };
            let position = (moved + DVec3::from_array(self.centre)).as_vec3();
            let color = Vec3::splat(1.0 / self.lights as f32);
            if light > 0 || self.area == 0 {
                return vec![Light { position, color }];
            }
            let half = [2, 3].map(|edge| dice.cube(edge) * 0.8);
            rectangle(position.as_dvec3(), half, self.area as usize, color).collect()
        });
        Frame { number, camera: self.camera(number), lights: lights.flatten().collect(), dynamic, visible }
    }

    fn camera(self, number: u32) -> Camera {
        let dice = self.dice(4);
        let shot = if self.camera == CameraPath::Jump { dice.part(u64::from(number)) } else { dice };
        let (sin, cos) = (TAU * shot.share(0)).sin_cos();
        let eye = DVec3::new(7.0 * cos, 3.0 + 3.0 * shot.share(1), 7.0 * sin);
        let pan = if self.camera == CameraPath::Pan {
            DVec3::new(0.01, 0.005, -0.01) * f64::from(number * number)
        } else {
            DVec3::ZERO
        };
        let centre = DVec3::from_array(self.centre);
        let mut camera = Camera::perspective(eye + pan + centre, pan - eye, DVec3::Y, 0.9);
        if self.camera == CameraPath::Jitter {
            let at = dice.part(u64::from(number));
            camera.jitter = DVec2::new(at.share(2), at.share(3)) - 0.5;
        }
        camera
    }
}
