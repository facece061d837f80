//! The corners of a face: indices of vertices, texture coordinates and normals.

use crate::scene::text::{shortened, words};

/// Numbers of vertices, texture coordinates and normals.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counts(pub [usize; 3]);

const KINDS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// A corner: indices from 0 into the lists of vertices, texture coordinates and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Corner {
    /// The vertex.
    pub vertex: usize,
    /// The texture coordinates.
    pub uv: Option<usize>,
    /// The normal.
    pub normal: Option<usize>,
}

/// Reads the corners of a face into `corners`. An index counts from 1; a negative index counts backwards from the end
/// of `seen`, the elements before the face in the file. `all` counts the elements of the whole file.
///
/// # Errors
/// Fewer than three corners, a word that is no corner, corners of different kinds, an index without its vertex.
pub(super) fn read(text: &str, seen: Counts, all: Counts, corners: &mut Vec<Corner>) -> Result<(), String> {
    corners.clear();
    for word in words(text) {
        let mut places = [None; 3];
        let mut parts = word.split('/');
        for (kind, part) in (0..3).zip(&mut parts) {
            if !part.is_empty() {
                places[kind] = Some(place(part, kind, seen.0[kind], all.0[kind])?);
            }
        }
        let [Some(vertex), uv, normal] = places else { return Err(no_corner(word)) };
        if parts.next().is_some() {
            return Err(no_corner(word));
        }
        corners.push(Corner { vertex, uv, normal });
    }
    if corners.len() < 3 {
        return Err(format!("a face of {} corners: at least 3 are needed", corners.len()));
    }
    let kind = |corner: &Corner| (corner.uv.is_some(), corner.normal.is_some());
    if corners.iter().any(|corner| kind(corner) != kind(&corners[0])) {
        return Err("the corners of a face give different kinds of index".into());
    }
    Ok(())
}

fn no_corner(word: &str) -> String {
    format!("{:?} is not a face's corner: v, v/vt, v//vn or v/vt/vn is", shortened(word))
}

fn place(part: &str, kind: usize, seen: usize, all: usize) -> Result<usize, String> {
    let no_index = || format!("{:?} is not an index of a face's corner", shortened(part));
    let asked: i64 = part.parse().map_err(|_| no_index())?;
    let distance = usize::try_from(asked.unsigned_abs()).map_err(|_| no_index())?;
    let place = if asked > 0 { distance.checked_sub(1) } else { seen.checked_sub(distance).filter(|_| distance > 0) };
    match place {
        Some(place) if place < all => Ok(place),
        Some(_) => Err(format!("{} {asked} is asked for, and there are {all}", KINDS[kind])),
        None => Err(no_index()),
    }
}
