//! Writing with the scene kept: new indices and modes in the document that was read, and nothing else.
//!
//! # Algorithm
//! 1. Find the index accessors, and the buffer views under them, that only the primitives to be written refer to. Every
//!    whole number inside of `extensions` or `extras` counts as a reference, since nobody knows what it means.
//! 2. Put each new accessor and view into the place of a free one, or at the end; so every other index keeps its meaning.
//! 3. Leave the bytes of free views out of the buffer, in steps of 8 bytes so that the alignment of all others stays, and
//!    move the other views down. Where an extension seems to name bytes, nothing is left out.
//! 4. Join all buffers, and put the new indices at the end.

mod extensions;
mod free;
mod moves;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use serde_json::{Map, Value, json};
use tristrip::Layout;

use self::extensions::{declare, drop_order_extensions, other_strips, undeclare};
use self::free::{Free, Loose};
use self::moves::{ALIGNMENT, Moves, set_buffer};
use super::document::{array, index, items, list_mut, whole};
use super::index::{Run, runs};
use super::{PrimitiveAt, RESTART_EXTENSION, Scene, TRIANGLES, container};
use crate::error::Error;
use crate::model::{Drawing, Model};

const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Tells whether an extension may name bytes of a buffer.
pub(super) fn names_bytes(root: &Map<String, Value>) -> bool {
    Loose::of(root).bytes_named
}

/// Writes the scene with new drawings.
pub(super) fn write(
    scene: &Scene,
    model: &Model,
    drawings: &[Drawing<'_>],
    layout: Layout,
) -> Result<Vec<u8>, Error> {
    scene.check_part_count(model.parts.len())?;
    let mut root = scene.root.clone();
    let rewritten: HashSet<(usize, usize)> = (scene.primitives.iter().zip(drawings))
        .filter(|(at, drawing)| !(at.mode == TRIANGLES && matches!(drawing, Drawing::Faces)))
        .map(|(at, _)| (at.mesh, at.primitive))
        .collect();

    // 1. What is free, by the document as it was read.
    let free = Free::find(&root, &rewritten)?;
    let moves = Moves::plan(&root, &scene.buffers, &free)?;

    // 2. New indices, part after part.
    let mut writer = IndexWriter { free, bytes: Vec::new(), views: BTreeMap::new(), by_old: HashMap::new() };
    let mut drawn: HashMap<(usize, usize), Vec<Drawn>> = HashMap::new();
    let mut restarts = false;
    for (part, (at, drawing)) in scene.primitives.iter().zip(drawings).enumerate() {
        if rewritten.contains(&(at.mesh, at.primitive)) {
            let runs = runs(part, &model.parts[part].mesh, *drawing, layout)?;
            restarts |= runs.iter().any(Run::restarts);
            drawn.insert((at.mesh, at.primitive), writer.place(&mut root, *at, &runs)?);
        }
    }
    draw(&mut root, &drawn)?;

    // 3. Extensions.
    drop_order_extensions(&mut root, &rewritten)?;
    if restarts {
        declare(&mut root, RESTART_EXTENSION)?;
    } else if !other_strips(&root)? {
        undeclare(&mut root, RESTART_EXTENSION);
    }

    // 4. Buffers.
    moves.apply(&mut root, &writer.views)?;
    let new = &writer.bytes;
    set_buffer(&mut root, if new.is_empty() { moves.end } else { moves.new_start() + new.len() })?;
    let json = serde_json::to_vec(&root).map_err(|e| Error::Unsupported(e.to_string()))?;
    container::write(&json, &moves.pieces(&scene.buffers, new))
}

/// What a primitive draws now.
#[derive(Clone)]
struct Drawn {
    mode: u64,
    accessor: usize,
    component: u32,
    count: usize,
}

impl Drawn {
    fn is_like(&self, run: &Run) -> bool {
        (self.mode, self.component, self.count) == (run.mode, run.component().code(), run.count())
    }
}

/// What became of an old index accessor.
struct Renewed {
    /// The new bytes.
    bytes: Range<usize>,
    drawn: Vec<Drawn>,
}

/// Packs new indices and gives them accessors and views.
struct IndexWriter {
    free: Free,
    bytes: Vec<u8>,
    /// New views, and where each starts within the new bytes.
    views: BTreeMap<usize, usize>,
    /// By old accessor: primitives that shared one share the new one if they are drawn alike.
    by_old: HashMap<usize, Renewed>,
}

impl IndexWriter {
    fn place(
        &mut self,
        root: &mut Map<String, Value>,
        at: PrimitiveAt,
        runs: &[Run],
    ) -> Result<Vec<Drawn>, Error> {
        // 1. The bytes: one view for all runs of the primitive.
        let start = self.bytes.len().next_multiple_of(ALIGNMENT);
        self.bytes.resize(start, 0);
        let mut offsets = Vec::with_capacity(runs.len());
        for run in runs {
            self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
            offsets.push(self.bytes.len() - start);
            run.pack(&mut self.bytes);
        }
        let primitive = array(root, "meshes")?.get(at.mesh).map(|m| items(m, "primitives"));
        let old = primitive.and_then(|p| p.get(at.primitive)?.get("indices")).and_then(index);
        if let Some(known) = old.and_then(|old| self.by_old.get(&old)) {
            let alike = runs.len() == known.drawn.len()
                && runs.iter().zip(&known.drawn).all(|(run, drawn)| drawn.is_like(run));
            if alike && self.bytes[known.bytes.clone()] == self.bytes[start..] {
                let drawn = known.drawn.clone();
                self.bytes.truncate(start);
                return Ok(drawn);
            }
        }
        // 2. The view, in the place of the old one if that is free.
        let old_free = old.filter(|old| self.free.accessors.remove(old));
        let old_view = old_free
            .and_then(|old| array(root, "accessors").ok()?.get(old)?.get("bufferView"))
            .and_then(index)
            .filter(|view| self.free.views.remove(view));
        let view = json!({
            "buffer": 0,
            "byteOffset": 0,
            "byteLength": self.bytes.len() - start,
            "target": ELEMENT_ARRAY_BUFFER,
        });
        let view = put(root, "bufferViews", old_view, view)?;
        self.views.insert(view, start);
        // 3. The accessors, the first in the place of the old one.
        let mut drawn = Vec::with_capacity(runs.len());
        for (i, (run, offset)) in runs.iter().zip(offsets).enumerate() {
            let mut accessor = json!({
                "bufferView": view,
                "componentType": run.component().code(),
                "count": run.count(),
                "type": "SCALAR",
            });
            if offset > 0 {
                accessor["byteOffset"] = offset.into();
            }
            let accessor = put(root, "accessors", old_free.filter(|_| i == 0), accessor)?;
            drawn.push(Drawn {
                mode: run.mode,
                accessor,
                component: run.component().code(),
                count: run.count(),
            });
        }
        if let Some(old) = old {
            let bytes = start..self.bytes.len();
            self.by_old.entry(old).or_insert_with(|| Renewed { bytes, drawn: drawn.clone() });
        }
        Ok(drawn)
    }
}

/// Puts an object into a place of a list, where name, extras and extensions stay, or at the end; gives the place.
fn put(
    root: &mut Map<String, Value>,
    list: &str,
    place: Option<usize>,
    value: Value,
) -> Result<usize, Error> {
    let entries = list_mut(root, list)?;
    let Some(place) = place else {
        entries.push(value);
        return Ok(entries.len() - 1);
    };
    if let (Some(Value::Object(old)), Value::Object(mut new)) = (entries.get_mut(place), value) {
        for key in ["name", "extras", "extensions"] {
            if let Some(kept) = old.shift_remove(key) {
                new.insert(key.to_owned(), kept);
            }
        }
        *old = new;
    }
    Ok(place)
}

/// Gives primitives their new modes and indices; one that is drawn as several becomes as many.
fn draw(root: &mut Map<String, Value>, drawn: &HashMap<(usize, usize), Vec<Drawn>>) -> Result<(), Error> {
    for (m, mesh) in list_mut(root, "meshes")?.iter_mut().enumerate() {
        let Some(Value::Array(primitives)) = mesh.get_mut("primitives") else { continue };
        let old = std::mem::take(primitives);
        for (p, mut primitive) in old.into_iter().enumerate() {
            let Some(drawn) = drawn.get(&(m, p)) else {
                primitives.push(primitive);
                continue;
            };
            for (i, one) in drawn.iter().enumerate() {
                let last = i + 1 == drawn.len();
                let mut copy = if last { std::mem::take(&mut primitive) } else { primitive.clone() };
                if let Value::Object(members) = &mut copy {
                    members.insert("indices".into(), one.accessor.into());
                    if members.get("mode").map_or(TRIANGLES, |mode| whole(mode).unwrap_or(TRIANGLES))
                        != one.mode
                    {
                        members.insert("mode".into(), one.mode.into());
                    }
                }
                primitives.push(copy);
            }
        }
    }
    Ok(())
}
