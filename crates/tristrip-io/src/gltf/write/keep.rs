//! Writes a model with its scene: only indices and modes of the document change.
//!
//! # Algorithm
//! 1. Find the index accessors and buffer views that only the rewritten primitives use. Every
//!    integer inside `extensions` or `extras` counts as a reference, because its meaning is
//!    unknown.
//! 2. Put each new accessor and view in place of an unused one, or append it. All other indices
//!    keep their meaning.
//! 3. Remove the bytes of unused views from the buffer, in multiples of 8 bytes to keep all
//!    alignments, and move the other views down. If an extension may refer to bytes, nothing is
//!    removed.
//! 4. Merge all buffers and append the new indices.

pub(in crate::gltf) mod compact;
pub(in crate::gltf) mod extensions;
pub(in crate::gltf) mod unused;

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use serde_json::json;
use tristrip::Layout;

use self::compact::{BufferCompaction, set_buffer};
use self::extensions::{declare, drop_order_extensions, has_line_strips, undeclare};
use self::unused::{Replaced, UnusedEntries};
use crate::error::Error;
use crate::gltf::document::byte_ranges::ALIGNMENT;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::container::{self, GlbContent};
use crate::gltf::document::json::{JsonContent, Members, Value};
use crate::gltf::document::scene::{PrimitiveRef, Scene};
use crate::gltf::document::spec::{ELEMENT_ARRAY_BUFFER, RESTART_EXTENSION, TRIANGLES};
use crate::gltf::document::{Document, array, entries_mut, index, items, list_mut, whole};
use crate::gltf::write::index::{IndexRun, pack_runs, runs};
use crate::model::{Drawing, Model};

/// A scene with new drawings, not yet written.
pub(in crate::gltf) struct KeptScene<'a> {
    document: Document,
    compaction: BufferCompaction,
    buffers: &'a [SharedBytes],
    /// The bytes of the new indices.
    new: Vec<u8>,
}

impl KeptScene<'_> {
    /// Returns the bytes of the merged buffer.
    fn slices(&self) -> Vec<&[u8]> {
        self.compaction.slices(self.buffers, &self.new)
    }

    /// Writes a GLB; the buffers are copied once.
    pub(in crate::gltf) fn write(&self) -> Result<Vec<u8>, Error> {
        container::write(&self.document.to_bytes(), &self.slices())
    }

    /// Merges the buffers, for further changes before writing.
    pub(in crate::gltf) fn joined(self) -> GlbContent {
        let buffer = self.slices().concat().into();
        GlbContent { document: self.document, buffer }
    }
}

/// Replaces the drawings of a scene. The caller has checked them.
pub(in crate::gltf) fn draw<'a>(
    scene: &'a Scene,
    model: &Model,
    drawings: &[Drawing<'_>],
    layout: Layout,
) -> Result<KeptScene<'a>, Error> {
    scene.check_part_count(model.parts.len())?;
    let mut document = scene.document.clone();
    let root = &mut document.root;
    let rewritten: HashSet<(usize, usize)> = (scene.primitives.iter().zip(drawings))
        .filter(|(source, drawing)| {
            source.is_redrawn || source.mode != TRIANGLES || !matches!(drawing, Drawing::Faces)
        })
        .map(|(source, _)| (source.mesh, source.primitive))
        .collect();

    // 1. Entries and bytes that become unused.
    let unused = UnusedEntries::find(root, &rewritten, Replaced::Indices)?;
    let compaction = BufferCompaction::plan(root, &scene.buffers, &unused)?;

    // 2. New indices of each part.
    let mut writer =
        IndexWriter { unused, bytes: Vec::new(), views: BTreeMap::new(), by_old: HashMap::new() };
    let mut drawn: HashMap<(usize, usize), Vec<DrawnPrimitive>> = HashMap::new();
    let mut restarts = false;
    for ((source, part), drawing) in scene.primitives.iter().zip(&model.parts).zip(drawings) {
        if rewritten.contains(&(source.mesh, source.primitive)) {
            let runs = runs(&part.mesh, *drawing, layout);
            restarts |= runs.iter().any(IndexRun::has_restarts);
            drawn.insert((source.mesh, source.primitive), writer.add(root, *source, &runs)?);
        }
    }
    set_primitives(root, &drawn)?;

    // 3. Extensions.
    drop_order_extensions(root, &rewritten)?;
    if restarts {
        declare(root, RESTART_EXTENSION)?;
    } else if !has_line_strips(root)? {
        undeclare(root, RESTART_EXTENSION);
    }

    // 4. Buffers.
    compaction.apply(root, &writer.views)?;
    let new = writer.bytes;
    set_buffer(root, if new.is_empty() { compaction.end } else { compaction.new_start() + new.len() })?;
    Ok(KeptScene { document, compaction, buffers: &scene.buffers, new })
}

/// The new mode and indices of a primitive.
#[derive(Clone)]
struct DrawnPrimitive {
    mode: u64,
    accessor: usize,
    component: u32,
    count: usize,
}

impl DrawnPrimitive {
    fn has_shape_of(&self, run: &IndexRun<'_>) -> bool {
        (self.mode, self.component, self.count) == (run.mode, run.component().code(), run.count())
    }
}

/// The replacement of an old index accessor.
struct ReplacedIndices {
    /// The new bytes.
    bytes: Range<usize>,
    drawn: Vec<DrawnPrimitive>,
}

/// Packs new indices and adds their accessors and buffer views.
struct IndexWriter {
    unused: UnusedEntries,
    bytes: Vec<u8>,
    /// The new views, each with its offset in the new bytes.
    views: BTreeMap<usize, usize>,
    /// By old accessor: primitives that shared one share the new one if their new indices are
    /// equal.
    by_old: HashMap<usize, ReplacedIndices>,
}

impl IndexWriter {
    fn add(
        &mut self,
        root: &mut Members,
        source: PrimitiveRef,
        runs: &[IndexRun<'_>],
    ) -> Result<Vec<DrawnPrimitive>, Error> {
        // 1. The bytes: one view for all runs of the primitive.
        let start = self.bytes.len().next_multiple_of(ALIGNMENT);
        self.bytes.resize(start, 0);
        let offsets = pack_runs(runs, &mut self.bytes);
        let primitive = array(root, "meshes")?.get(source.mesh).map(|m| items(m, "primitives"));
        let old = primitive.and_then(|p| p.get(source.primitive)?.get("indices")).and_then(index);
        if let Some(known) = old.and_then(|old| self.by_old.get(&old)) {
            let same_shape = runs.len() == known.drawn.len()
                && runs.iter().zip(&known.drawn).all(|(run, drawn)| drawn.has_shape_of(run));
            if same_shape && self.bytes[known.bytes.clone()] == self.bytes[start..] {
                let drawn = known.drawn.clone();
                self.bytes.truncate(start);
                return Ok(drawn);
            }
        }
        // 2. The view, in place of the old one if that is unused.
        let old_unused = old.filter(|old| self.unused.accessors.remove(old));
        let old_view = old_unused
            .and_then(|old| array(root, "accessors").ok()?.get(old)?.get("bufferView"))
            .and_then(index)
            .filter(|view| self.unused.views.remove(view));
        let view = json!({
            "buffer": 0,
            "byteOffset": 0,
            "byteLength": self.bytes.len() - start,
            "target": ELEMENT_ARRAY_BUFFER,
        });
        let view = put(root, "bufferViews", old_view, view.into())?;
        self.views.insert(view, start);
        // 3. The accessors, the first in place of the old one.
        let mut drawn = Vec::with_capacity(runs.len());
        for (i, (run, offset)) in runs.iter().zip(offsets).enumerate() {
            let accessor = run.accessor(view, offset);
            let accessor = put(root, "accessors", old_unused.filter(|_| i == 0), accessor.into())?;
            drawn.push(DrawnPrimitive {
                mode: run.mode,
                accessor,
                component: run.component().code(),
                count: run.count(),
            });
        }
        if let Some(old) = old {
            let bytes = start..self.bytes.len();
            self.by_old.entry(old).or_insert_with(|| ReplacedIndices { bytes, drawn: drawn.clone() });
        }
        Ok(drawn)
    }
}

/// Replaces an entry of a list except for its name, extras and extensions, or appends a new one.
/// Returns its index.
fn put(root: &mut Members, list: &str, replaced: Option<usize>, value: Value) -> Result<usize, Error> {
    let entries = list_mut(root, list)?;
    let Some(replaced) = replaced else {
        entries.push(value);
        return Ok(entries.len() - 1);
    };
    let old = entries.get_mut(replaced).and_then(Value::as_object_mut);
    if let (Some(old), JsonContent::Object(mut new)) = (old, value.content) {
        for name in ["name", "extras", "extensions"] {
            new.take_from(old, name);
        }
        *old = new;
    }
    Ok(replaced)
}

/// Sets the modes and indices of primitives. A primitive with several drawings is split.
fn set_primitives(
    root: &mut Members,
    drawn: &HashMap<(usize, usize), Vec<DrawnPrimitive>>,
) -> Result<(), Error> {
    let changed: HashSet<usize> = drawn.keys().map(|&(mesh, _)| mesh).collect();
    for (m, mesh) in entries_mut(root, "meshes")?.iter_mut().enumerate().filter(|(m, _)| changed.contains(m))
    {
        let members = mesh.as_object_mut();
        let primitives = members.and_then(|mesh| mesh.get_mut("primitives")).and_then(Value::as_array_mut);
        let Some(primitives) = primitives else { continue };
        let old = std::mem::take(primitives);
        for (p, primitive) in old.into_iter().enumerate() {
            let Some(drawn) = drawn.get(&(m, p)) else {
                primitives.push(primitive);
                continue;
            };
            for one in drawn {
                let mut copy = primitive.clone();
                if let Some(members) = copy.as_object_mut() {
                    members.insert("indices", one.accessor);
                    if members.get("mode").map_or(TRIANGLES, |mode| whole(mode).unwrap_or(TRIANGLES))
                        != one.mode
                    {
                        members.insert("mode", one.mode);
                    }
                }
                primitives.push(copy);
            }
        }
    }
    Ok(())
}
