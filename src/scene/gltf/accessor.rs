//! Accessors: typed elements in a buffer, with steps between them, normalized integers and sparse substitutes (section
//! "Accessors").

use gltf_json::Root;
use gltf_json::accessor::{ComponentType, Type};
use gltf_json::validation::Checked;

use super::buffers::Buffers;

/// The elements of an accessor, each of `N` numbers.
#[derive(Debug)]
pub(super) struct Elements<'a, const N: usize> {
    /// The elements in a buffer; all zero if there are none.
    stored: Option<Stored<'a>>,
    substitutes: Option<Substitutes<'a>>,
    count: usize,
    component: ComponentType,
    normalized: bool,
}

/// Elements at equal distances.
#[derive(Clone, Copy, Debug)]
struct Stored<'a> {
    bytes: &'a [u8],
    step: usize,
}

/// Elements that replace others (a sparse accessor).
#[derive(Debug)]
struct Substitutes<'a> {
    /// Numbers of the replaced elements, ascending.
    places: Vec<usize>,
    values: Stored<'a>,
}

impl<'a, const N: usize> Elements<'a, N> {
    /// Accessor number `index`; `what` names it in errors.
    ///
    /// # Errors
    /// The accessor does not exist, its elements are not of `N` numbers, or they lie outside the buffer.
    pub(super) fn new(root: &Root, buffers: &'a Buffers, index: usize, what: &str) -> Result<Self, String> {
        Self::read(root, buffers, index).map_err(|error| format!("{what}, accessor {index}: {error}"))
    }

    fn read(root: &Root, buffers: &'a Buffers, index: usize) -> Result<Self, String> {
        let accessor = root.accessors.get(index).ok_or("it is not there")?;
        let (Checked::Valid(component), Checked::Valid(kind)) = (accessor.component_type, accessor.type_) else {
            return Err("its type is not one of the specification".into());
        };
        let component = component.0;
        let numbers = match kind {
            Type::Scalar => 1,
            Type::Vec2 => 2,
            Type::Vec3 => 3,
            Type::Vec4 | Type::Mat2 => 4,
            Type::Mat3 => 9,
            Type::Mat4 => 16,
        };
        if numbers != N {
            return Err(format!("its elements are of {numbers} numbers: {N} are needed"));
        }
        let count = usize::try_from(accessor.count.0).map_err(|_| "its count is too large")?;
        // Elements without bytes are zero; the file's size bounds their number, too.
        if count > buffers.size() {
            return Err(format!("{count} elements are told: the file has {} bytes in buffers", buffers.size()));
        }
        let size = N * component.size();
        let stored = |view: usize, offset: u64, count: usize, size: usize| -> Result<Stored<'a>, String> {
            let step = root.buffer_views.get(view).and_then(|view| view.byte_stride).map_or(size, |step| step.0);
            let bytes = buffers.view(root, view)?;
            let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..)).unwrap_or_default();
            let needed = count.saturating_sub(1).checked_mul(step).and_then(|last| last.checked_add(size));
            if step < size || (count > 0 && needed.is_none_or(|needed| needed > bytes.len())) {
                return Err(format!("its {count} elements are not within buffer view {view}"));
            }
            Ok(Stored { bytes, step })
        };
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let base = accessor.buffer_view.map(|view| stored(view.value(), offset, count, size)).transpose()?;
        let substitutes = match &accessor.sparse {
            None => None,
            Some(sparse) => {
                let length = usize::try_from(sparse.count.0).ok().filter(|length| *length <= count);
                let length = length.ok_or("it has more sparse elements than elements")?;
                let Checked::Valid(kind) = sparse.indices.component_type else {
                    return Err("its sparse indices are of no type of the specification".into());
                };
                let indices = &sparse.indices;
                let places = stored(indices.buffer_view.value(), indices.byte_offset.0, length, kind.0.size())?;
                let places = (0..length).map(|at| number(kind.0, &places.bytes[at * places.step..]) as usize);
                let places: Vec<usize> = places.collect();
                if !places.is_sorted_by(|one, next| one < next) || places.last().is_some_and(|last| *last >= count) {
                    return Err("its sparse indices do not rise, or lie beyond its elements".into());
                }
                let values = &sparse.values;
                Some(Substitutes {
                    places,
                    values: stored(values.buffer_view.value(), values.byte_offset.0, length, size)?,
                })
            }
        };
        Ok(Self { stored: base, substitutes, count, component, normalized: accessor.normalized })
    }

    /// Number of elements.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The type of the numbers, and whether they are normalized to 0 to 1 or -1 to 1.
    pub(super) fn component(&self) -> (ComponentType, bool) {
        (self.component, self.normalized)
    }

    /// Element number `index`, if it exists.
    pub(super) fn get(&self, index: usize) -> Option<[f64; N]> {
        if index >= self.count {
            return None;
        }
        let substitute = self.substitutes.as_ref().and_then(|substitutes| {
            let at = substitutes.places.binary_search(&index).ok()?;
            Some((substitutes.values, at))
        });
        let Some((from, at)) = substitute.or(self.stored.map(|stored| (stored, index))) else { return Some([0.0; N]) };
        let size = self.component.size();
        Some(std::array::from_fn(|part| {
            self.scaled(number(self.component, &from.bytes[at * from.step + part * size..]))
        }))
    }

    /// All elements.
    pub(super) fn iter(&self) -> impl Iterator<Item = [f64; N]> + '_ {
        (0..self.count).filter_map(|index| self.get(index))
    }

    /// Section "Animations": normalized integers stand for 0 to 1, or for -1 to 1, where the lowest number also means
    /// -1.
    fn scaled(&self, number: f64) -> f64 {
        match self.component {
            _ if !self.normalized => number,
            ComponentType::I8 => (number / 127.0).max(-1.0),
            ComponentType::U8 => number / 255.0,
            ComponentType::I16 => (number / 32767.0).max(-1.0),
            ComponentType::U16 => number / 65535.0,
            ComponentType::U32 | ComponentType::F32 => number,
        }
    }
}

/// The number at the start of `bytes`, which are long enough.
fn number(component: ComponentType, bytes: &[u8]) -> f64 {
    match component {
        ComponentType::I8 => f64::from(bytes[0] as i8),
        ComponentType::U8 => f64::from(bytes[0]),
        ComponentType::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        ComponentType::U32 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        ComponentType::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
    }
}
