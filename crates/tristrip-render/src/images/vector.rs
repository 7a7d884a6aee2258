//! Points and vectors.

/// A point or vector.
pub(super) type Vector = [f64; 3];

pub(super) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns a vector scaled to length 1, or `None` if it has no direction.
pub(super) fn unit(a: Vector) -> Option<Vector> {
    // Scale first, so the squares of very large and very small vectors neither overflow nor
    // underflow.
    let largest = a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    let a = a.map(|x| x / largest);
    let length = dot(a, a).sqrt();
    Some(a.map(|x| x / length))
}

/// Returns the weighted sum of values at three corners.
pub(super) fn mix<const N: usize>(weights: Vector, corners: [[f64; N]; 3]) -> [f64; N] {
    std::array::from_fn(|i| {
        weights[0] * corners[0][i] + weights[1] * corners[1][i] + weights[2] * corners[2][i]
    })
}
