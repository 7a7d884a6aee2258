//! Tracks of an animation. Finds the keyframes that interpolation reproduces.

use crate::gltf::document::Located;
use crate::gltf::document::accessor::{AccessorResolver, AccessorValues};
use crate::gltf::document::bounds::number;
use crate::gltf::document::budget::DecodeBudget;
use crate::gltf::document::json::Value;
use crate::gltf::document::spec::ComponentType;

/// Maximum error of a track, relative to its largest absolute value: a few times the error of
/// 32-bit rounding when an exporter computes the track from a matrix.
const TOLERANCE: f64 = 1.0 / 1_048_576.0;

/// Maximum number of keyframes from a kept one to the next; it makes the time linear.
const LONGEST: usize = 32;

/// Minimum cosine of half the rotation angle of an arc.
const MIN_COSINE: f64 = 0.92;

/// Times and their values.
pub(super) struct Track {
    times: Vec<f32>,
    /// The values as stored in the file.
    raw: Vec<u8>,
    numbers: Vec<f64>,
    /// Numbers per keyframe.
    width: usize,
    /// Components per value; a keyframe of morph weights has several values.
    pub(super) components: usize,
    pub(super) component: ComponentType,
    pub(super) normalized: bool,
    is_step: bool,
    is_rotation: bool,
    /// The largest absolute value.
    greatest: f64,
}

impl Track {
    /// Decodes the track of a sampler. Returns `None` if its keyframes must not change.
    pub(super) fn decode(
        resolver: &AccessorResolver<'_>,
        sampler: &Value,
        path: &str,
        budget: &mut DecodeBudget,
    ) -> Option<Self> {
        let is_step = match sampler.get("interpolation") {
            None => false,
            Some(name) => match name.as_str()? {
                "LINEAR" => false,
                "STEP" => true,
                _ => return None,
            },
        };
        let values = |name| {
            let value = sampler.get(name)?;
            resolver.values(&Located { value, at: name.into() }).ok()
        };
        let (input, output): (AccessorValues<'_>, AccessorValues<'_>) = (values("input")?, values("output")?);
        let components = match path {
            "translation" | "scale" => 3,
            "rotation" => 4,
            "weights" => 1,
            _ => return None,
        };
        let is_understood = (input.component, input.components) == (ComponentType::F32, 1)
            && output.components == components
            && !output.matrix
            && output.count.is_multiple_of(input.count)
            && (components == 1 || output.count == input.count);
        // Raw bytes, 64-bit numbers, and a copy of each.
        let bytes = output.components * (output.component.bytes() + 8);
        if !is_understood || !budget.try_charge(input.count, 8) || !budget.try_charge(output.count, 2 * bytes)
        {
            return None;
        }
        let times: Vec<f32> =
            input.raw().ok()?.as_chunks::<4>().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect();
        let ascends = times.is_sorted_by(|a, b| a < b) && times.iter().all(|time| time.is_finite());
        let raw = output.raw().ok()?;
        let scale = match output.component {
            ComponentType::F32 => 1.0,
            _ if !output.normalized => return None,
            ComponentType::I8 => 127.0,
            ComponentType::U8 => 255.0,
            ComponentType::I16 => 32767.0,
            ComponentType::U16 => 65535.0,
            ComponentType::U32 => return None,
        };
        let one = |bytes: &[u8]| {
            (number(output.component, bytes) / scale).max(if scale > 1.0 { -1.0 } else { f64::MIN })
        };
        let numbers: Vec<f64> = raw.chunks_exact(output.component.bytes()).map(one).collect();
        let greatest = numbers.iter().fold(0.0_f64, |greatest, x| greatest.max(x.abs()));
        // `fold` with `max` ignores NaN, so every number is checked.
        if !ascends || !numbers.iter().all(|x| x.is_finite() && x.abs() <= f64::from(f32::MAX)) {
            return None;
        }
        Some(Self {
            width: numbers.len() / times.len(),
            times,
            raw,
            numbers,
            components,
            component: output.component,
            normalized: output.normalized,
            is_step,
            is_rotation: path == "rotation",
            greatest,
        })
    }

    /// Returns the number of keyframes, at least one.
    pub(super) fn len(&self) -> usize {
        self.times.len()
    }

    pub(super) fn time(&self, key: usize) -> f32 {
        self.times[key]
    }

    pub(super) fn first_time(&self) -> f32 {
        self.times[0]
    }

    pub(super) fn last_time(&self) -> f32 {
        self.times[self.times.len() - 1]
    }

    /// Returns the bytes of the value at a keyframe.
    pub(super) fn key(&self, key: usize) -> &[u8] {
        &self.raw[key * self.key_bytes()..][..self.key_bytes()]
    }

    /// Returns the value at a keyframe in 16 bits per component, if it is a rotation stored as
    /// 32-bit floats.
    pub(super) fn rounded(&self, key: usize) -> Option<impl Iterator<Item = i16>> {
        let is_rounded =
            self.is_rotation && self.component == ComponentType::F32 && self.greatest <= 1.0 + TOLERANCE;
        let of = |x: &f64| (x.clamp(-1.0, 1.0) * f64::from(i16::MAX)).round() as i16;
        is_rounded.then(|| self.value(key).iter().map(of))
    }

    pub(super) fn key_bytes(&self) -> usize {
        self.width * self.component.bytes()
    }

    /// Returns the `type` of the accessor.
    pub(super) fn kind(&self) -> &'static str {
        match self.components {
            1 => "SCALAR",
            3 => "VEC3",
            _ => "VEC4",
        }
    }

    fn value(&self, key: usize) -> &[f64] {
        &self.numbers[key * self.width..][..self.width]
    }

    fn tolerance(&self) -> f64 {
        TOLERANCE * self.greatest
    }

    fn is_near(&self, a: &[f64], b: &[f64]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= self.tolerance())
    }

    /// Checks whether all values are equal: within the tolerance, or exactly in step tracks.
    pub(super) fn is_constant(&self) -> bool {
        let is_same = |key| {
            if self.is_step {
                self.key(key) == self.key(0)
            } else {
                self.is_near(self.value(key), self.value(0))
            }
        };
        (1..self.len()).all(is_same)
    }

    /// Checks whether the first value equals `value` within the tolerance.
    pub(super) fn begins_with(&self, value: &[f64]) -> bool {
        self.is_near(self.value(0), value)
    }

    /// Returns the keyframes to keep, ascending, including the first and the last.
    pub(super) fn kept(&self) -> Vec<usize> {
        let last = self.len() - 1;
        let mut kept = vec![0];
        let mut from = 0;
        for key in 1..last {
            let stays = if self.is_step {
                self.key(key) != self.key(from)
            } else {
                key + 1 - from > LONGEST || !self.is_given_back(from, key + 1)
            };
            if stays {
                kept.push(key);
                from = key;
            }
        }
        kept.extend((last > 0).then_some(last));
        kept
    }

    /// Checks whether interpolation between two keyframes reproduces all keyframes between them.
    fn is_given_back(&self, from: usize, to: usize) -> bool {
        let [start, end] = [from, to].map(|key| f64::from(self.times[key]));
        let (a, b) = (self.value(from), self.value(to));
        let arc = if self.is_rotation { Arc::of(a, b) } else { None };
        if self.is_rotation && arc.as_ref().is_none_or(|arc| arc.cosine < MIN_COSINE) {
            return false;
        }
        (from + 1..to).all(|key| {
            let share = (f64::from(self.times[key]) - start) / (end - start);
            let [of_a, of_b] = arc.as_ref().map_or([1.0 - share, share], |arc| arc.weights(share));
            let numbers = self.value(key).iter().zip(a.iter().zip(b));
            numbers.into_iter().all(|(x, (a, b))| (of_a * a + of_b * b - x).abs() <= self.tolerance())
        })
    }
}

/// The shorter arc between two quaternions.
struct Arc {
    cosine: f64,
    angle: f64,
    sign: f64,
}

impl Arc {
    /// Returns the arc, or `None` if a quaternion has no direction.
    fn of(a: &[f64], b: &[f64]) -> Option<Self> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let cosine = dot(a, b) / (dot(a, a) * dot(b, b)).sqrt();
        let (cosine, sign) = (cosine.abs().min(1.0), if cosine < 0.0 { -1.0 } else { 1.0 });
        cosine.is_finite().then(|| Self { cosine, angle: libm::acos(cosine), sign })
    }

    /// Returns the weights of both ends at a fraction of the arc for spherical linear
    /// interpolation.
    fn weights(&self, share: f64) -> [f64; 2] {
        let sine = libm::sin(self.angle);
        if sine < 1e-9 {
            return [1.0 - share, self.sign * share];
        }
        [libm::sin((1.0 - share) * self.angle) / sine, self.sign * libm::sin(share * self.angle) / sine]
    }
}
