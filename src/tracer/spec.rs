//! How frames become rays: settings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::accel::AccelSpec;
use crate::scene::RenderSpec;

/// How frames become rays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TracerSpec {
    /// How pictures are traced.
    pub render: RenderSpec,
    /// What rays are traced in.
    pub accel: AccelSpec,
    /// The order of pixels in the stream. No decision depends on it; what caches hit does.
    pub order: PixelOrder,
}

/// The order of pixels in a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PixelOrder {
    /// Row by row from the top, as the published algorithm goes.
    #[default]
    Scanline,
    /// Square tiles of eight pixels a side, row by row, and row by row inside.
    Tiles,
}

/// Number of rows that are traced and recorded as one chunk, equal to a tile's height. It bounds memory, and the share
/// of work for the row above, which is traced again for the reference pixels.
pub(super) const BAND_ROWS: u32 = 8;
