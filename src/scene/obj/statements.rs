//! Statements of OBJ files that have an effect here, those that have none, and those that are refused.
//!
//! Source: Wavefront Technologies, "Advanced Visualizer Manual", Appendix B1, "Object Files (.obj)", version 3.0; its
//! sections are named beside the statements.

/// Known statements without effect on ray hits or on colours here.
pub(super) const WITHOUT_EFFECT: &[&str] = &[
    // Vertex data: points in the parameter space of curves.
    "vp", // Free-form curve/surface attributes. A surface needs `surf`, which is refused.
    "cstype", "deg", "bmat", "step", // Elements without area: points, lines, curves.
    "p", "l", "curv", "curv2", // Body statements of curves and surfaces.
    "parm", "trim", "hole", "scrv", "sp", "end", // Connectivity between free-form surfaces.
    "con", // Grouping: without normals of its own a face is flat, whatever its smoothing group.
    "g", "s", "mg", "o",
    // Display and render attributes of other renderers; texture maps come with the material.
    "bevel", "c_interp", "d_interp", "lod", "maplib", "usemap", "ctech", "stech",
    // Superseded: curves, and the number of segments of patches.
    "cdc", "res",
];

/// Statements that would change ray hits, and are not supported.
const REFUSED: &[(&str, &str)] = &[
    ("surf", "free-form surfaces are not read"),
    ("bsp", "patches are not read"),
    ("bzp", "patches are not read"),
    ("cdp", "patches are not read"),
    ("call", "other files are not read from within an OBJ file"),
    ("csh", "commands are not run"),
    ("shadow_obj", "objects that only cast shadows are not read"),
    ("trace_obj", "objects that only reflections show are not read"),
];

/// Why a statement that is neither read nor without effect is refused.
pub(super) fn refusal(word: &str) -> String {
    match REFUSED.iter().find(|(refused, _)| *refused == word) {
        Some((_, why)) => format!("`{word}` is not allowed: {why}"),
        None => format!(
            "`{}` is no statement of an OBJ file: v, vt, vn, f, mtllib and usemtl are read, and these have no \
             effect: {}",
            crate::scene::text::shortened(word).escape_debug(),
            WITHOUT_EFFECT.join(" ")
        ),
    }
}
