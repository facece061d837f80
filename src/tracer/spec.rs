//! How frames become rays: settings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::accel::AccelSpec;
use crate::scene::RenderSpec;

/// How the tracer turns frames into ray streams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TracerSpec {
    /// How pictures are rendered.
    pub render: RenderSpec,
    /// The acceleration structure.
    pub accel: AccelSpec,
    /// The order of pixels in the stream. It changes cache hits. Policies that learn within a band of rows also skip
    /// slightly different rays.
    pub order: PixelOrder,
}

/// The order of pixels in a stream.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum PixelOrder {
    /// Row by row from the top, as in the published algorithm.
    #[default]
    Scanline,
    /// Tiles of 8 x 8 pixels, row by row. The pixels of a tile also come row by row.
    Tiles,
}

/// Number of rows that are traced and recorded as one chunk, equal to a tile's height. It bounds memory, and the share
/// of work for the row above, which is traced again for the reference pixels. With a live policy the whole picture is
/// one band.
pub(super) const BAND_ROWS: u32 = 8;
