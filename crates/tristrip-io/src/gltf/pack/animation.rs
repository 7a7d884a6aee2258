//! Reduces the keyframes of animations: removes keyframes that interpolation of their neighbours
//! reproduces.
//!
//! ```text
//! value      ·   ·                       kept: first, last, and changes of direction
//!          ·       ·   ·   ·   ·
//!        ·
//! kept   x       x     x           x
//! ```
//! # Algorithm
//! 1. Each sampler of translations, rotations, scales or morph weights becomes a track of times and
//!    values.
//! 2. If all values of a track are equal, it keeps its first keyframe. It also keeps its last
//!    keyframe, unless other tracks of the animation contain its first and last times. The start
//!    and end of the animation therefore do not change. If the value also equals the node's own
//!    value, and no other animation changes that property, the channel is removed.
//! 3. In other linear tracks, a keyframe is kept if the segment from the last kept keyframe to the
//!    next one would deviate from a keyframe in between by more than the tolerance. Between
//!    keyframes, both curves are line segments or arcs of the same circle, so the error is largest
//!    at the keyframes. The number of keyframes per segment is bounded. An arc of a rotation spans
//!    at most 46 degrees, because players may interpolate rotations differently.
//! 4. In step tracks, a keyframe is kept if its value differs from the previous one. Cubic splines
//!    keep all keyframes.
//! 5. Samplers without a channel are removed. Rotations are rounded to 16 bits if requested.

mod track;

use std::collections::{HashMap, HashSet};

use serde_json::json;

use self::track::Track;
use super::packing::{AppendedAccessors, Packing, Rounding, entry_mut};
use crate::error::Error;
use crate::gltf::document::budget::{ATTRIBUTE_LIMIT, DecodeBudget};
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::references::has_number;
use crate::gltf::document::spec::ComponentType;
use crate::gltf::document::{Located, array, index, items, uses};
use crate::gltf::edit::permute::VERTEX_FACTOR;

/// Approximate JSON size of an accessor in bytes: the cost of separate keyframe times for a track.
const ACCESSOR_BYTES: usize = 120;

/// Removes keyframes, and channels without effect.
pub(super) fn reduce(scene: &mut Packing, rounding: Rounding) -> Result<(), Error> {
    let root = &scene.document.root;
    let mut budget = DecodeBudget::new(ATTRIBUTE_LIMIT, VERTEX_FACTOR, &scene.buffers);
    let targets = Targets::of(root)?;
    let mut new = AppendedAccessors::of(root)?;
    let mut changes = Vec::new();
    for animation in array(root, "animations")? {
        let tracks = tracks(scene, animation, &mut budget);
        changes.push(AnimationChange::of(animation, &tracks, &targets, rounding, &mut new));
    }
    scene.append(new)?;
    for (number, change) in changes.into_iter().enumerate() {
        if let Some(animation) = entry_mut(&mut scene.document.root, "animations", number)? {
            change.apply(animation);
        }
    }
    Ok(())
}

/// Decodes the samplers of an animation; `None` for samplers that must not change.
fn tracks(scene: &Packing, animation: &Value, budget: &mut DecodeBudget) -> Vec<Option<Track>> {
    let samplers = items(animation, "samplers");
    let mut paths: Vec<HashSet<&str>> = vec![HashSet::new(); samplers.len()];
    for channel in items(animation, "channels") {
        let sampler = channel.get("sampler").and_then(index).and_then(|sampler| paths.get_mut(sampler));
        // A channel that an extension targets has no path of the specification.
        let path = target(channel).map_or("", |(_, path)| path);
        sampler.into_iter().for_each(|paths| paths.extend([path]));
    }
    let decoded = samplers.iter().zip(&paths).map(|(sampler, paths)| {
        let mut paths = paths.iter();
        let path = paths.next().filter(|_| paths.next().is_none())?;
        Track::decode(&scene.resolver(), sampler, path, budget)
    });
    decoded.collect()
}

/// Returns the node and the property that a channel animates.
fn target(channel: &Value) -> Option<(usize, &str)> {
    let target = channel.get("target").filter(|target| target.get("extensions").is_none())?;
    Some((target.get("node").and_then(index)?, target.get("path")?.as_str()?))
}

/// The animated properties.
struct Targets<'a> {
    root: &'a Members,
    /// The number of channels by node and property.
    channels: HashMap<(usize, &'a str), usize>,
    /// Whether an extension may animate further properties.
    has_pointers: bool,
}

impl<'a> Targets<'a> {
    fn of(root: &'a Members) -> Result<Self, Error> {
        let mut channels: HashMap<(usize, &str), usize> = HashMap::new();
        for channel in array(root, "animations")?.iter().flat_map(|animation| items(animation, "channels")) {
            target(channel).into_iter().for_each(|target| *channels.entry(target).or_default() += 1);
        }
        Ok(Self { root, channels, has_pointers: uses(root, "KHR_animation_pointer") })
    }

    /// Checks whether a channel only sets its node's own value and nothing else animates it.
    fn is_at_rest(&self, channel: &Value, track: &Track) -> bool {
        let Some((number, path)) = target(channel).filter(|_| !self.has_pointers) else { return false };
        let default: &[f64] = match path {
            "translation" => &[0.0; 3],
            "rotation" => &[0.0, 0.0, 0.0, 1.0],
            "scale" => &[1.0; 3],
            _ => return false,
        };
        let node = array(self.root, "nodes").ok().and_then(|nodes| nodes.get(number));
        let Some(node) = node.filter(|node| node.get("matrix").is_none()) else { return false };
        let rest: Vec<f64> = match node.get(path) {
            None => default.to_vec(),
            Some(value) => {
                let numbers = value.as_array().unwrap_or_default().iter();
                numbers.filter_map(|value| Located { value, at: String::new() }.number().ok()).collect()
            }
        };
        let names_more = ["extensions", "extras"].iter().any(|name| channel.get(name).is_some());
        !names_more && self.channels.get(&(number, path)) == Some(&1) && track.begins_with(&rest)
    }
}

/// The changes of an animation.
#[derive(Default)]
struct AnimationChange {
    /// The new times and values of samplers.
    samplers: HashMap<usize, (usize, usize)>,
    /// The removed channels.
    channels: HashSet<usize>,
}

impl AnimationChange {
    fn of(
        animation: &Value,
        tracks: &[Option<Track>],
        targets: &Targets<'_>,
        rounding: Rounding,
        new: &mut AppendedAccessors,
    ) -> Self {
        let mut change = Self::default();
        let known = || tracks.iter().flatten();
        let first = known().map(Track::first_time).fold(f32::INFINITY, f32::min);
        let last = known().map(Track::last_time).fold(f32::NEG_INFINITY, f32::max);
        let mut moving = known().filter(|track| !track.is_constant());
        let begins = moving.clone().any(|track| track.first_time() <= first);
        // The tracks that keep their first and last keyframes cover the whole animation.
        let is_covered = begins && moving.any(|track| track.last_time() >= last);
        for (number, track) in tracks.iter().enumerate() {
            let Some(track) = track else { continue };
            let kept = match track.is_constant() {
                true if is_covered => vec![0],
                true => vec![0, track.len() - 1],
                false => track.kept(),
            };
            let removed = track.len().saturating_sub(kept.len());
            // Tracks of one or two keyframes share their times with others.
            let cost = if kept.len() <= 2 { 0 } else { ACCESSOR_BYTES + 4 * kept.len() };
            let rounds = rounding == Rounding::WeightsAndRotations && track.rounded(0).is_some();
            let pays = removed * track.key_bytes() > cost;
            if pays || rounds {
                let kept = if pays { kept } else { (0..track.len()).collect() };
                change.samplers.insert(number, add(track, &kept, rounds, new));
            }
        }
        let names_more =
            ["extensions", "extras"].iter().any(|name| animation.get(name).is_some_and(has_number));
        if is_covered && !names_more {
            for (number, channel) in items(animation, "channels").iter().enumerate() {
                let track =
                    channel.get("sampler").and_then(index).and_then(|sampler| tracks.get(sampler)?.as_ref());
                if track.is_some_and(|track| track.is_constant() && targets.is_at_rest(channel, track)) {
                    change.channels.insert(number);
                }
            }
        }
        change
    }

    fn apply(self, animation: &mut Members) {
        let samplers = animation.get_mut("samplers").filter(|_| !self.samplers.is_empty());
        for (number, sampler) in samplers.and_then(Value::as_array_mut).into_iter().flatten().enumerate() {
            if let Some((&(input, output), members)) = self.samplers.get(&number).zip(sampler.as_object_mut())
            {
                members.insert("input", input);
                members.insert("output", output);
            }
        }
        if self.channels.is_empty() {
            return;
        }
        let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) else { return };
        let mut number = 0..;
        channels.retain(|_| number.next().is_none_or(|number| !self.channels.contains(&number)));
        // The samplers that are still used, by their new indices.
        let mut used: Vec<usize> =
            channels.iter().filter_map(|channel| channel.get("sampler").and_then(index)).collect();
        used.sort_unstable();
        used.dedup();
        for channel in channels {
            let old = channel.get("sampler").and_then(index).and_then(|old| used.binary_search(&old).ok());
            if let Some((new, members)) = old.zip(channel.as_object_mut()) {
                members.insert("sampler", new);
            }
        }
        let samplers = animation.get_mut("samplers").and_then(Value::as_array_mut);
        let mut number = 0..;
        samplers.into_iter().for_each(|samplers| {
            samplers.retain(|_| number.next().is_none_or(|number| used.binary_search(&number).is_ok()));
        });
    }
}

/// Adds the times and values of the kept keyframes.
fn add(track: &Track, kept: &[usize], rounds: bool, new: &mut AppendedAccessors) -> (usize, usize) {
    let times: Vec<f32> = kept.iter().map(|&key| track.time(key)).collect();
    let bytes: Vec<u8> = times.iter().flat_map(|time| time.to_le_bytes()).collect();
    let bound = |key: usize| json!([f64::from(times[key])]);
    let input = json!({
        "componentType": 5126, "count": times.len(), "type": "SCALAR", "min": bound(0), "max": bound(times.len() - 1),
    });
    let input = new.add(&bytes, input);
    let (bytes, component): (Vec<u8>, _) = if rounds {
        let rounded = kept.iter().filter_map(|&key| track.rounded(key)).flatten();
        (rounded.flat_map(i16::to_le_bytes).collect(), ComponentType::I16)
    } else {
        (kept.iter().flat_map(|&key| track.key(key)).copied().collect(), track.component)
    };
    let count = bytes.len() / (track.components * component.bytes());
    let mut output = json!({ "componentType": component.code(), "count": count, "type": track.kind() });
    if track.normalized || rounds {
        output["normalized"] = true.into();
    }
    (input, new.add(&bytes, output))
}
