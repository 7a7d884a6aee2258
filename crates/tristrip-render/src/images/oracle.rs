//! Compares the rasterizer with ray casting through every sample.

use tristrip::{Attribute, AttributeData, Faces, Mesh, random::Random};
use tristrip_io::{Model, Part};

use super::camera::Camera;
use super::options::{Mode, RenderOptions, View};
use super::raster::SAMPLES;
use super::textured::TexturedModel;
use super::vector::{Vector, cross, dot, mix, sub, unit};

const SIZE: u32 = 20;

/// Random triangles in a cube, with normals and texture coordinates at their corners.
struct Soup {
    corners: Vec<[Vector; 3]>,
    normals: Vec<[Vector; 3]>,
    coordinates: Vec<[[f64; 2]; 3]>,
}

impl Soup {
    fn new(count: usize, next: &mut impl FnMut() -> f32) -> (Self, Model) {
        let mut floats =
            |count: usize, low: f32| -> Vec<f32> { (0..count).map(|_| low + (1.0 - low) * next()).collect() };
        let (positions, normals) = (floats(9 * count, -1.0), floats(9 * count, -1.0));
        let coordinates = floats(6 * count, -3.0);
        let triples = |values: &[f32]| values.as_chunks::<3>().0.to_vec();
        let attribute = |name: &str, components, values: &[f32]| Attribute {
            name: name.into(),
            components,
            normalized: false,
            data: AttributeData::F32(values.to_vec()),
        };
        let faces = Faces::from_triangles((0..3 * count as u32).collect()).unwrap();
        let mesh = Mesh::new(triples(&positions), faces).unwrap();
        let mesh = mesh.with_attribute(attribute("NORMAL", 3, &normals)).unwrap();
        let mesh = mesh.with_attribute(attribute("TEXCOORD_0", 2, &coordinates)).unwrap();
        let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
        let vectors = |values: &[f32]| {
            let all: Vec<Vector> = triples(values).into_iter().map(|v| v.map(f64::from)).collect();
            all.as_chunks::<3>().0.to_vec()
        };
        let pairs: Vec<[f64; 2]> = coordinates.as_chunks::<2>().0.iter().map(|v| v.map(f64::from)).collect();
        let normals = vectors(&normals).into_iter().map(|n| n.map(|n| unit(n).unwrap())).collect();
        (
            Self { corners: vectors(&positions), normals, coordinates: pairs.as_chunks::<3>().0.to_vec() },
            model,
        )
    }

    /// Returns the nearest triangle that a ray hits, and the barycentric coordinates of the hit.
    fn hit(&self, eye: Vector, direction: Vector) -> Option<(usize, Vector)> {
        let mut nearest: Option<(f64, usize, Vector)> = None;
        for (number, &[a, b, c]) in self.corners.iter().enumerate() {
            // Möller and Trumbore: Fast, minimum storage ray/triangle intersection, 1997.
            let (ab, ac) = (sub(b, a), sub(c, a));
            let p = cross(direction, ac);
            let determinant = dot(ab, p);
            let from = sub(eye, a);
            let beta = dot(from, p) / determinant;
            let q = cross(from, ab);
            let gamma = dot(direction, q) / determinant;
            let distance = dot(ac, q) / determinant;
            let shares = [1.0 - beta - gamma, beta, gamma];
            let inside = shares.iter().all(|&share| share >= 0.0) && distance > 0.0;
            if inside && nearest.is_none_or(|(known, ..)| distance < known) {
                nearest = Some((distance, number, shares));
            }
        }
        nearest.map(|(_, number, shares)| (number, shares))
    }

    /// Returns the expected value of a ray for a mode.
    fn value(&self, hit: Option<(usize, Vector)>, mode: Mode) -> Vector {
        let Some((number, shares)) = hit else { return [1.0; 3] };
        if mode == Mode::Normals {
            return unit(mix(shares, self.normals[number])).unwrap().map(|x| x / 2.0 + 0.5);
        }
        // A triangle wave of period 2.
        let [u, v] = mix(shares, self.coordinates[number]).map(|x| (x - 2.0 * (x / 2.0).round()).abs());
        [u, v, 0.5]
    }
}

#[test]
fn random_triangles_are_what_rays_meet() {
    let mut random = Random::new(7);
    let mut next = move || random.below(1 << 20) as f32 / (1 << 20) as f32;
    let mut shown = 0;
    for round in 0..12 {
        let (soup, model) = Soup::new(1 + 3 * round, &mut next);
        let textured = TexturedModel::new(&model).unwrap();
        let from = [next() - 0.5, next() - 0.5, 0.3].map(f64::from);
        let options =
            RenderOptions::default().with_size(SIZE, SIZE + 3).with_view(View { from, up: [0.1, 1.0, 0.0] });
        let camera = textured.camera(&options).unwrap().unwrap();
        for mode in [Mode::Normals, Mode::Uv] {
            let pixels = textured.seen(&camera, mode, &options).unwrap();
            for (at, pixel) in pixels.iter().enumerate() {
                let (x, y) = (at % SIZE as usize, at / SIZE as usize);
                let (colour, alpha) = expected(&soup, &camera, [x, y], options.height, mode);
                assert_eq!(pixel[3], alpha, "round {round}, pixel {x} {y}");
                for channel in 0..3 {
                    let found = f64::from(pixel[channel]);
                    assert!(
                        (found - 255.0 * colour[channel]).abs() < 0.51,
                        "{mode:?} {x} {y}: {pixel:?} {colour:?}"
                    );
                }
                shown += usize::from(alpha > 0);
            }
        }
    }
    assert!(shown > 2000, "{shown}");
}

/// Averages the rays through the samples of a pixel.
fn expected(soup: &Soup, camera: &Camera, [x, y]: [usize; 2], height: u32, mode: Mode) -> (Vector, u8) {
    let (mut sum, mut covered) = ([0.0; 3], 0);
    for sample in 0..SAMPLES * SAMPLES {
        let inside = |at: usize| (at as f64 + 0.5) / SAMPLES as f64;
        let (right, down) = (x as f64 + inside(sample % SAMPLES), y as f64 + inside(sample / SAMPLES));
        let (eye, direction) = camera.ray([right, f64::from(height) - down]).unwrap();
        let hit = soup.hit(eye, direction);
        covered += usize::from(hit.is_some());
        sum.iter_mut().zip(soup.value(hit, mode)).for_each(|(sum, value)| *sum += value);
    }
    let all = SAMPLES * SAMPLES;
    (sum.map(|sum| sum / all as f64), (255 * covered / all) as u8)
}
