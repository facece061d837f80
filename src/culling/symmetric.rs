//! The published algorithm with occlusion tests in both directions: the current pixel's ray against the other pixel's
//! primitive, and the other pixel's ray against the current primitive.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::published::rules::{Directions, Preset, PublishedRules, References};

/// The published algorithm with occlusion tests in both directions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SymmetricSpec {
    /// Which neighbour pixels are compared.
    pub neighbours: Neighbours,
    /// The preset for all other answers.
    pub preset: Preset,
}

/// Which neighbours a pixel is compared with over the whole frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Neighbours {
    /// The neighbours to the left, right, above and below.
    #[default]
    Four,
    /// Also the four diagonal neighbours.
    Eight,
}

impl SymmetricSpec {
    /// The rules of the published algorithm with these settings.
    pub fn rules(self) -> PublishedRules {
        let references = match self.neighbours {
            Neighbours::Four => References::LeftAndUpper,
            Neighbours::Eight => References::WithDiagonals,
        };
        PublishedRules { directions: Directions::BothWays, references, ..self.preset.rules() }
    }
}
