//! A face of a PLY file.

use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};
use smallvec::SmallVec;

/// Names of the one property of a face that is read; a file has one of them.
pub(super) const PROPERTIES: &[&str] = &["vertex_indices", "vertex_index"];

/// A face.
#[derive(Clone, Debug, Default)]
pub(super) struct Face {
    /// Indices of its corners in the list of vertices.
    pub indices: SmallVec<[i64; 4]>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !PROPERTIES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.indices = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}
