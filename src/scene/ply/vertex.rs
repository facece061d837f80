//! A vertex of a PLY file.

use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

/// Properties of a vertex that are read.
pub(super) const PROPERTIES: &[&str] = &["x", "y", "z", "nx", "ny", "nz", "u", "v", "s", "t", "texture_u", "texture_v"];

/// A vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Vertex {
    /// Where it is.
    pub position: [f64; 3],
    /// Its normal, of any length; zero if there is none.
    pub normal: [f64; 3],
    /// Its texture coordinates.
    pub uv: [f64; 2],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let place = match name {
            "x" => &mut self.position[0],
            "y" => &mut self.position[1],
            "z" => &mut self.position[2],
            "nx" => &mut self.normal[0],
            "ny" => &mut self.normal[1],
            "nz" => &mut self.normal[2],
            "u" | "s" | "texture_u" => &mut self.uv[0],
            "v" | "t" | "texture_v" => &mut self.uv[1],
            _ => return PropertyAccessResult::Ignored,
        };
        match number(&property) {
            Some(number) => {
                *place = number;
                PropertyAccessResult::Set
            }
            None => PropertyAccessResult::UnsupportedType,
        }
    }
}

/// The number of a property that is no list.
fn number(property: &Property) -> Option<f64> {
    match *property {
        Property::Char(value) => Some(value.into()),
        Property::UChar(value) => Some(value.into()),
        Property::Short(value) => Some(value.into()),
        Property::UShort(value) => Some(value.into()),
        Property::Int(value) => Some(value.into()),
        Property::UInt(value) => Some(value.into()),
        Property::Float(value) => Some(value.into()),
        Property::Double(value) => Some(value),
        _ => None,
    }
}

/// An element that is skipped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ignored;

impl PropertyAccess for Ignored {
    fn new() -> Self {
        Self
    }
}
