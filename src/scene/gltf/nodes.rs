//! The tree of nodes, and their poses over time.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf_json::Root;

use super::animation::{Motion, unit};
use super::document::name;
use crate::scene::limits::COORDINATE;
use crate::scene::model::PoseAt;

/// The nodes of the file's scene.
#[derive(Debug)]
pub(super) struct Tree {
    /// By number in the file; `None` if the scene does not reach it.
    nodes: Vec<Option<Node>>,
    /// Numbers of the reached nodes, parents first.
    order: Vec<usize>,
    place: DAffine3,
}

#[derive(Debug)]
struct Node {
    parent: Option<usize>,
    local: Local,
    motion: Motion,
    /// Whether it or a node above it moves.
    moves: bool,
}

/// A node's own transform.
#[derive(Clone, Copy, Debug)]
enum Local {
    Matrix(DAffine3),
    Parts { translation: DVec3, rotation: DQuat, scale: DVec3 },
}

impl Tree {
    /// The nodes of the file's default scene; `motions` are the nodes' motions by number, and `place` maps the scene to
    /// the world.
    ///
    /// # Errors
    /// No scene; a node that does not exist, has two parents or is its own ancestor; a transform out of range.
    pub(super) fn new(root: &Root, mut motions: Vec<Motion>, place: DAffine3) -> Result<Self, String> {
        let scene = root.scene.map_or(0, |scene| scene.value());
        let scene = root.scenes.get(scene).ok_or("it has no scene")?;
        let mut tree = Self { nodes: root.nodes.iter().map(|_| None).collect(), order: Vec::new(), place };
        let mut open: Vec<_> = scene.nodes.iter().rev().map(|node| (node.value(), None)).collect();
        while let Some((index, parent)) = open.pop() {
            let node = root.nodes.get(index).ok_or_else(|| format!("node {index} is not there"))?;
            if tree.nodes[index].is_some() {
                return Err(format!("node {} has two parents or is below itself", name(root, index)));
            }
            let local = local(node).map_err(|what| format!("node {}: {what}", name(root, index)))?;
            let motion = std::mem::take(&mut motions[index]);
            if motion.is_there() && matches!(local, Local::Matrix(_)) {
                return Err(format!("node {} has a matrix and is moved: only one is allowed", name(root, index)));
            }
            let moves = motion.moves() || parent.is_some_and(|parent| tree.moves(parent));
            tree.nodes[index] = Some(Node { parent, local, motion, moves });
            tree.order.push(index);
            let children = node.children.iter().flatten().rev();
            open.extend(children.map(|child| (child.value(), Some(index))));
        }
        Ok(tree)
    }

    /// Numbers of the scene's nodes, parents first.
    pub(super) fn order(&self) -> &[usize] {
        &self.order
    }

    /// Whether a node or one above it moves.
    pub(super) fn moves(&self, index: usize) -> bool {
        self.nodes[index].as_ref().is_some_and(|node| node.moves)
    }

    /// Number of the scene's nodes that an animation holds in one pose.
    pub(super) fn held(&self) -> usize {
        let motions = self.nodes.iter().flatten().map(|node| &node.motion);
        motions.filter(|motion| motion.is_there() && !motion.moves()).count()
    }

    /// From the node's space to the world at a time in seconds.
    fn world(&self, index: usize, time: f64) -> DAffine3 {
        let mut world = DAffine3::IDENTITY;
        let mut next = Some(index);
        while let Some(node) = next.and_then(|index| self.nodes[index].as_ref()) {
            world = node.at(time) * world;
            next = node.parent;
        }
        self.place * world
    }

    /// The pose of a node over time.
    pub(super) fn pose(self: &Arc<Self>, index: usize) -> PoseAt {
        let tree = self.clone();
        if self.moves(index) {
            Arc::new(move |time| tree.world(index, time))
        } else {
            let still = tree.world(index, 0.0);
            Arc::new(move |_| still)
        }
    }
}

impl Node {
    fn at(&self, time: f64) -> DAffine3 {
        match self.local {
            Local::Matrix(matrix) => matrix,
            Local::Parts { translation, rotation, scale } => {
                let motion = &self.motion;
                DAffine3::from_scale_rotation_translation(
                    motion.scale.as_ref().map_or(scale, |track| track.at(time)),
                    motion.rotation.as_ref().map_or(rotation, |track| track.at(time)),
                    motion.translation.as_ref().map_or(translation, |track| track.at(time)),
                )
            }
        }
    }
}

fn local(node: &gltf_json::Node) -> Result<Local, String> {
    let vector = |numbers: [f32; 3]| DVec3::from_array(numbers.map(f64::from));
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        matrix.to_cols_array().into_iter().try_for_each(|number| COORDINATE.check("a matrix", number).map(|_| ()))?;
        if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
            return Err("the last row of its matrix is not 0 0 0 1".into());
        }
        let [x, y, z, w] = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(|axis| axis.truncate());
        return Ok(Local::Matrix(DAffine3 { matrix3: DMat3::from_cols(x, y, z), translation: w }));
    }
    let translation = COORDINATE.check_vector("a translation", node.translation.map_or(DVec3::ZERO, vector))?;
    let scale = COORDINATE.check_vector("a scale", node.scale.map_or(DVec3::ONE, vector))?;
    let rotation = node.rotation.map_or(Ok(DQuat::IDENTITY), |rotation| unit(rotation.0.map(f64::from)))?;
    Ok(Local::Parts { translation, rotation, scale })
}
