//! Writing with the scene kept: new indices and modes in the document that was read, and nothing else.
//!
//! # Algorithm
//! 1. Find the index accessors, and the buffer views under them, that only the primitives to be written refer to. Every
//!    whole number inside of `extensions` or `extras` counts as a reference, since nobody knows what it means.
//! 2. Put each new accessor and view into the place of a free one, or at the end; so every other index keeps its meaning.
//! 3. Leave the bytes of free views out of the buffer, in steps of 8 bytes so that the alignment of all others stays, and
//!    move the other views down. Where an extension seems to name bytes, nothing is left out.
//! 4. Join all buffers, and put the new indices at the end.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;

use serde_json::{Map, Value, json};
use tristrip::Layout;

use super::buffer::Bytes;
use super::document::{array, format_error, whole};
use super::index::{Run, runs};
use super::read::ORDER_EXTENSIONS;
use super::{PrimitiveAt, RESTART_EXTENSION, Scene, TRIANGLES, container};
use crate::error::Error;
use crate::model::{Drawing, Model};

const ELEMENT_ARRAY_BUFFER: u32 = 34963;
/// Some extensions ask for this alignment of buffer views; nothing in use asks for more.
const ALIGNMENT: usize = 8;

/// Writes the scene with new drawings.
pub(super) fn write(
    scene: &Scene,
    model: &Model,
    drawings: &[Drawing<'_>],
    layout: Layout,
) -> Result<Vec<u8>, Error> {
    if scene.primitives.len() != model.parts.len() {
        return Err(Error::Unsupported(format!(
            "parts: found {}, expected {} as in the scene that was read",
            model.parts.len(),
            scene.primitives.len()
        )));
    }
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

/// Accessors and views that nobody refers to once the new indices are in place.
struct Free {
    accessors: HashSet<usize>,
    views: HashSet<usize>,
    /// Whether an extension may name bytes of a buffer.
    bytes_named: bool,
}

impl Free {
    fn find(root: &Map<String, Value>, rewritten: &HashSet<(usize, usize)>) -> Result<Self, Error> {
        let mut loose = Loose::default();
        root.iter().for_each(|(key, value)| loose.member(key, value, false));

        // Accessors: old indices, less everything else that is referred to.
        let mut pinned = loose.numbers.clone();
        let mut old = HashSet::new();
        for (m, mesh) in array(root, "meshes")?.iter().enumerate() {
            for (p, primitive) in items(mesh, "primitives").iter().enumerate() {
                let sink = if rewritten.contains(&(m, p)) { &mut old } else { &mut pinned };
                sink.extend(primitive.get("indices").and_then(index));
                pinned.extend(primitive.get("attributes").into_iter().flat_map(values).filter_map(index));
                for target in items(primitive, "targets") {
                    pinned.extend(values(target).filter_map(index));
                }
            }
        }
        for skin in array(root, "skins")? {
            pinned.extend(skin.get("inverseBindMatrices").and_then(index));
        }
        for animation in array(root, "animations")? {
            for sampler in items(animation, "samplers") {
                pinned.extend(["input", "output"].iter().filter_map(|k| sampler.get(*k)).filter_map(index));
            }
        }
        let accessors: HashSet<usize> = old.difference(&pinned).copied().collect();

        // Views: those of free accessors, less everything else that is referred to.
        let mut pinned = loose.numbers;
        let mut old = HashSet::new();
        for (a, accessor) in array(root, "accessors")?.iter().enumerate() {
            let sink = if accessors.contains(&a) { &mut old } else { &mut pinned };
            sink.extend(accessor.get("bufferView").and_then(index));
            for part in ["indices", "values"] {
                let view = accessor.get("sparse").and_then(|s| s.get(part)?.get("bufferView"));
                pinned.extend(view.and_then(index));
            }
        }
        for image in array(root, "images")? {
            pinned.extend(image.get("bufferView").and_then(index));
        }
        let views = old.difference(&pinned).copied().collect();
        Ok(Self { accessors, views, bytes_named: loose.bytes_named })
    }
}

/// Numbers inside of extensions and extras.
#[derive(Default)]
struct Loose {
    numbers: HashSet<usize>,
    bytes_named: bool,
}

impl Loose {
    fn member(&mut self, key: &str, value: &Value, inside: bool) {
        let inside_now = inside || key == "extensions" || key == "extras";
        self.bytes_named |= inside && matches!(key, "buffer" | "byteOffset" | "byteLength");
        match value {
            Value::Object(members) => members.iter().for_each(|(k, v)| self.member(k, v, inside_now)),
            Value::Array(items) => items.iter().for_each(|v| self.member("", v, inside_now)),
            Value::Number(_) if inside_now => self.numbers.extend(index(value)),
            _ => {}
        }
    }
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

/// Which bytes of the buffers stay, and where they go.
struct Moves {
    /// The bytes of each buffer that go, ascending and apart, and how many have gone at the end of each.
    removed: Vec<Vec<(Range<usize>, usize)>>,
    /// Where each buffer starts in the one that all become.
    bases: Vec<usize>,
    /// Where the last of them ends.
    end: usize,
}

impl Moves {
    fn plan(root: &Map<String, Value>, buffers: &[Bytes], free: &Free) -> Result<Self, Error> {
        if free.bytes_named && buffers.len() > 1 {
            return Err(Error::Unsupported(
                "an extension names bytes of a buffer: several buffers cannot be joined into one".into(),
            ));
        }
        let mut kept: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
        let mut freed = kept.clone();
        for (v, view) in array(root, "bufferViews")?.iter().enumerate() {
            let (buffer, range) = view_range(v, view, buffers)?;
            let sink = if free.views.contains(&v) { &mut freed } else { &mut kept };
            sink[buffer].push(range);
        }
        let mut moves = Self { removed: Vec::new(), bases: Vec::new(), end: 0 };
        for ((bytes, freed), kept) in buffers.iter().zip(freed).zip(kept) {
            let gone = if free.bytes_named { Vec::new() } else { subtract(merge(freed), &merge(kept)) };
            let mut total = 0;
            let removed = gone.into_iter().map(|range| {
                total += range.len();
                (range, total)
            });
            moves.removed.push(removed.collect());
            moves.bases.push(moves.end.next_multiple_of(ALIGNMENT));
            moves.end = moves.end.next_multiple_of(ALIGNMENT) + bytes.len() - total;
        }
        Ok(moves)
    }

    /// Gives the place where new bytes start.
    fn new_start(&self) -> usize {
        self.end.next_multiple_of(ALIGNMENT)
    }

    /// Moves all views; `new` has the offsets of new ones within the new bytes.
    fn apply(&self, root: &mut Map<String, Value>, new: &BTreeMap<usize, usize>) -> Result<(), Error> {
        if !root.contains_key("bufferViews") {
            return Ok(());
        }
        for (v, view) in list_mut(root, "bufferViews")?.iter_mut().enumerate() {
            let Value::Object(members) = view else { continue };
            let offset = members.get("byteOffset").and_then(index).unwrap_or(0);
            let moved = if let Some(start) = new.get(&v) {
                self.new_start() + start
            } else {
                let buffer = members.get("buffer").and_then(index).unwrap_or(0);
                if buffer != 0 {
                    members.insert("buffer".into(), 0.into());
                }
                let Some((removed, base)) = self.removed.get(buffer).zip(self.bases.get(buffer)) else {
                    continue;
                };
                let before = removed.partition_point(|(gone, _)| gone.end <= offset);
                base + offset - before.checked_sub(1).map_or(0, |last| removed[last].1)
            };
            if moved != offset {
                members.insert("byteOffset".into(), moved.into());
            }
        }
        Ok(())
    }

    /// Gives the bytes that stay, each buffer at its base, and the new ones after them.
    fn pieces<'a>(&self, buffers: &'a [Bytes], new: &'a [u8]) -> Vec<&'a [u8]> {
        const PADDING: &[u8] = &[0; ALIGNMENT];
        let mut pieces = Vec::new();
        let mut written = 0;
        let mut push = |piece: &'a [u8]| {
            written += piece.len();
            pieces.push(piece);
            written
        };
        for ((bytes, removed), &base) in buffers.iter().zip(&self.removed).zip(&self.bases) {
            let bytes = bytes.as_slice();
            let before = push(&[]);
            push(&PADDING[..base - before]);
            let mut at = 0;
            for (gone, _) in removed {
                push(&bytes[at..gone.start]);
                at = gone.end;
            }
            push(&bytes[at..]);
        }
        if !new.is_empty() {
            push(&PADDING[..self.new_start() - self.end]);
            push(new);
        }
        pieces
    }
}

/// Gives a view's buffer and range; reading has checked both.
fn view_range(v: usize, view: &Value, buffers: &[Bytes]) -> Result<(usize, Range<usize>), Error> {
    let field = |name| view.get(name).and_then(index);
    let (buffer, start, length) =
        (field("buffer").unwrap_or(0), field("byteOffset").unwrap_or(0), field("byteLength").unwrap_or(0));
    let fits =
        buffers.get(buffer).is_some_and(|b| start.checked_add(length).is_some_and(|end| end <= b.len()));
    if fits {
        return Ok((buffer, start..start + length));
    }
    Err(format_error(format!("bufferViews[{v}]"), "a range outside of its buffer", "one within"))
}

/// Sorts ranges and joins those that touch.
fn merge(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    ranges.sort_unstable_by_key(|r| r.start);
    let mut out: Vec<Range<usize>> = Vec::with_capacity(ranges.len());
    for range in ranges {
        match out.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => out.push(range),
        }
    }
    out
}

/// Takes `kept` away from `freed`, both sorted and apart, and shrinks what is left to the alignment.
fn subtract(freed: Vec<Range<usize>>, kept: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut push = |start: usize, end: usize| {
        let (start, end) = (start.next_multiple_of(ALIGNMENT), end / ALIGNMENT * ALIGNMENT);
        if start < end {
            out.push(start..end);
        }
    };
    let mut next = 0;
    for range in freed {
        let mut start = range.start;
        while let Some(keep) = kept.get(next).filter(|keep| keep.start < range.end) {
            push(start, keep.start.max(start));
            start = start.max(keep.end);
            if keep.end > range.end {
                break;
            }
            next += 1;
        }
        push(start, range.end.max(start));
    }
    out
}

/// Makes all buffers one of a length; none where there are no bytes.
fn set_buffer(root: &mut Map<String, Value>, length: usize) -> Result<(), Error> {
    if length == 0 && !root.contains_key("buffers") {
        return Ok(());
    }
    let buffers = list_mut(root, "buffers")?;
    buffers.truncate(1);
    match buffers.first_mut() {
        Some(Value::Object(buffer)) => {
            if buffer.get("byteLength").and_then(index) != Some(length) {
                buffer.insert("byteLength".into(), length.into());
            }
        }
        _ => buffers.push(json!({ "byteLength": length })),
    }
    Ok(())
}

/// Takes extensions that describe the order of indices off the meshes whose indices are new.
fn drop_order_extensions(
    root: &mut Map<String, Value>,
    rewritten: &HashSet<(usize, usize)>,
) -> Result<(), Error> {
    if !ORDER_EXTENSIONS.iter().any(|name| super::document::uses(root, name)) {
        return Ok(());
    }
    let written: HashSet<usize> = rewritten.iter().map(|&(mesh, _)| mesh).collect();
    let mut left: HashSet<&str> = HashSet::new();
    for (m, mesh) in list_mut(root, "meshes")?.iter_mut().enumerate() {
        let mut clean = |object: &mut Value| {
            let Some(Value::Object(extensions)) = object.get_mut("extensions") else { return };
            for name in ORDER_EXTENSIONS {
                if written.contains(&m) {
                    extensions.shift_remove(name);
                } else if extensions.contains_key(name) {
                    left.insert(name);
                }
            }
            if extensions.is_empty()
                && let Value::Object(members) = object
            {
                members.shift_remove("extensions");
            }
        };
        clean(mesh);
        if let Some(Value::Array(primitives)) = mesh.get_mut("primitives") {
            primitives.iter_mut().for_each(clean);
        }
    }
    for name in ORDER_EXTENSIONS.iter().filter(|name| !left.contains(*name)) {
        undeclare(root, name);
    }
    Ok(())
}

/// Tells whether there are line strips or loops, which may have restarts; strips and fans never stay as they are.
fn other_strips(root: &Map<String, Value>) -> Result<bool, Error> {
    Ok(array(root, "meshes")?.iter().any(|mesh| {
        items(mesh, "primitives").iter().any(|p| matches!(p.get("mode").and_then(whole), Some(2 | 3)))
    }))
}

fn declare(root: &mut Map<String, Value>, name: &str) -> Result<(), Error> {
    for list in ["extensionsUsed", "extensionsRequired"] {
        let names = list_mut(root, list)?;
        if !names.iter().any(|n| n == name) {
            names.push(name.into());
        }
    }
    Ok(())
}

fn undeclare(root: &mut Map<String, Value>, name: &str) {
    for list in ["extensionsUsed", "extensionsRequired"] {
        if let Some(Value::Array(names)) = root.get_mut(list) {
            let before = names.len();
            names.retain(|n| n != name);
            // An empty list is not allowed.
            if names.is_empty() && before > 0 {
                root.shift_remove(list);
            }
        }
    }
}

fn list_mut<'a>(root: &'a mut Map<String, Value>, list: &str) -> Result<&'a mut Vec<Value>, Error> {
    match root.entry(list).or_insert_with(|| Value::Array(Vec::new())) {
        Value::Array(entries) => Ok(entries),
        _ => Err(format_error(list, "something else", "an array")),
    }
}

fn items<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value.get(name).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn values(object: &Value) -> impl Iterator<Item = &Value> {
    object.as_object().into_iter().flat_map(Map::values)
}

fn index(value: &Value) -> Option<usize> {
    usize::try_from(whole(value)?).ok()
}
