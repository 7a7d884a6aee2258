//! Flights through the committed cameras: the time and the vertices sent per frame, compared with
//! strips that are computed from scratch.

use std::fs;
use std::path::Path;
use std::time::Instant;

use tristrip::lod::{Camera, Filter, SkipView, ViewCriteria};
use tristrip::{Faces, Mesh, Method, StripifyOptions, stripify};
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::median;
use tristrip_bench::targets::Target;
use tristrip_bench::text::Table;
use tristrip_lab::flight::{FlightPath, Lens};

use crate::building::BuiltModel;
use crate::frames::Frame;
use crate::others::{self, OtherFigures, Others};
use crate::proof::sorted;

/// A flight and its targets.
struct Flight {
    /// The name of its camera file in `testdata/views`.
    name: &'static str,
    model: &'static str,
    /// The error in pixels, chosen for about the published number of triangles.
    pixels: f32,
    /// The maximum fraction of three vertices per triangle that `dtfs` and repaired strips may
    /// send.
    most: Option<[f64; 2]>,
    /// The maximum time of a frame in milliseconds.
    milliseconds: Option<f64>,
}

/// The flights. Their triangle counts are those of tables 3 and 4 of the paper.
const FLIGHTS: [Flight; 5] = [
    Flight { name: "bunny_10k", model: "bunny", pixels: 1.463, most: Some([0.66, 0.45]), milliseconds: None },
    Flight { name: "bunny_30k", model: "bunny", pixels: 0.473, most: None, milliseconds: None },
    Flight { name: "bunny_50k", model: "bunny", pixels: 0.1037, most: Some([0.5, 0.42]), milliseconds: None },
    Flight {
        name: "terrain_255k",
        model: "terrain_gcanyon_512",
        pixels: 0.1034,
        most: Some([0.52, 0.42]),
        milliseconds: None,
    },
    Flight {
        name: "dragon_445k",
        model: "dragon",
        pixels: 0.0376,
        most: Some([0.55, 0.42]),
        milliseconds: Some(4.0),
    },
];
/// The minimum fraction of triangles for which the time of a frame has a target relative to strips
/// from scratch.
const DETAILED: f64 = 0.3;
/// The number of evenly spaced frames that are proven, whose vertices sent are counted, and whose
/// strips are computed from scratch.
const SAMPLES: usize = 5;
/// The number of repetitions of a flight. The time of a frame is the median.
const ROUNDS: usize = 5;

/// The measurements of a flight.
pub(super) struct FlightFigures {
    name: &'static str,
    pixels: f32,
    /// The fraction of the triangles of the full mesh.
    detail: f64,
    triangles: f64,
    moved: f64,
    looked_at: f64,
    /// The time of an update in milliseconds, and of an update with repaired strips.
    milliseconds: f64,
    worst: f64,
    repair_milliseconds: f64,
    /// The vertices sent as fractions of three per triangle: by `dtfs`, `linked` and repaired
    /// strips, and by `dtfs` on a level.
    sent: [f64; 4],
    /// The milliseconds and the vertices sent of strips from scratch, by method.
    again: Vec<(Method, f64, f64)>,
    pub(super) others: Vec<OtherFigures>,
}

/// Flies all flights of a model.
pub(super) fn fly_all(built: &BuiltModel, frame_count: usize) -> Result<Vec<FlightFigures>, Failure> {
    let others = Others::build(built)?;
    let flights = FLIGHTS.iter().filter(|flight| flight.model == built.figures.name);
    flights.map(|flight| fly(built, &others, flight, frame_count)).collect()
}

fn fly(
    built: &BuiltModel,
    others: &Others,
    flight: &Flight,
    frame_count: usize,
) -> Result<FlightFigures, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../testdata/views");
    let text = fs::read_to_string(folder.join(format!("{}.json", flight.name)))?;
    let cameras = FlightPath::from_json(&text)?.cameras(frame_count, Lens::default())?;
    let criteria = ViewCriteria::default().with_pixels(flight.pixels);
    let is_sample = |frame: usize| frame % (frame_count / SAMPLES).max(1) == frame_count / SAMPLES / 2;
    prove(built, &cameras, &criteria, is_sample)?;

    let rounds = (0..ROUNDS).map(|_| times(built, &cameras, &criteria)).collect::<Result<Vec<_>, _>>()?;
    let of_frame = |frame: usize| median(rounds.iter().map(|times| times[frame]).collect());
    let milliseconds: Vec<f64> = (1..cameras.len()).map(of_frame).collect();
    let mut view = built.model.view();
    let (mut triangles, mut moved, mut looked_at) = (vec![], vec![], vec![]);
    let (mut sent, mut again) = (vec![[0.0; 4]; 0], Vec::new());
    let mut frames = Vec::new();
    for (frame, camera) in cameras.iter().enumerate() {
        let update = view.update(camera, &criteria)?;
        frames.push(Frame::new(*camera, &built.mesh, is_sample(frame), view.triangle_count()));
        if frame > 0 {
            triangles.push(view.triangle_count() as f64);
            moved.push((update.collapses + update.splits) as f64 / view.active_vertex_count() as f64);
            looked_at.push(update.looked_at as f64);
        }
        if is_sample(frame) {
            sent.push(sent_by(built, &mut view)?);
            again.extend(compute_again(&built.mesh, &view)?);
        }
    }
    let others = others::fly_all(flight.name, built, others, &frames, &criteria)?;
    let repaired = others.iter().find(|row| row.name == others::REPAIRED);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let mean_of = |i: usize| mean(&sent.iter().map(|sent| sent[i]).collect::<Vec<_>>());
    let by_method = AGAIN.map(|method| {
        let of = |i: usize| {
            let rows = again.iter().filter(|(other, ..)| *other == method);
            median(rows.map(|row: &(Method, [f64; 2])| row.1[i]).collect())
        };
        (method, of(0), of(1))
    });
    let worst = milliseconds.iter().copied().fold(0.0, f64::max);
    let full = built.strips.triangles().count();
    let triangles = median(triangles);
    Ok(FlightFigures {
        name: flight.name,
        pixels: flight.pixels,
        detail: triangles / full as f64,
        triangles,
        moved: mean(&moved),
        looked_at: median(looked_at),
        milliseconds: median(milliseconds),
        worst,
        repair_milliseconds: repaired.map_or(f64::NAN, |row| row.milliseconds),
        sent: [mean_of(0), mean_of(1), repaired.map_or(f64::NAN, |row| row.fraction), mean_of(2)],
        again: by_method.to_vec(),
        others,
    })
}

/// Returns the time of each frame in milliseconds.
fn times(built: &BuiltModel, cameras: &[Camera], criteria: &ViewCriteria) -> Result<Vec<f64>, Failure> {
    let mut view = built.model.view();
    let time = |camera| {
        let start = Instant::now();
        view.update(camera, criteria)?;
        Ok(1e3 * start.elapsed().as_secs_f64())
    };
    cameras.iter().map(time).collect()
}

/// Proves, in a sample of the frames, that display strips draw the triangles of the view.
fn prove(
    built: &BuiltModel,
    cameras: &[Camera],
    criteria: &ViewCriteria,
    is_sample: impl Fn(usize) -> bool,
) -> Result<(), Failure> {
    let mut view = built.model.view();
    for (frame, camera) in cameras.iter().enumerate() {
        view.update(camera, criteria)?;
        if is_sample(frame) && sorted(view.display_strips().triangles()) != sorted(view.renamed_triangles()) {
            return Err(format!("{}: frame {frame} draws other triangles", built.figures.name).into());
        }
    }
    Ok(())
}

/// Returns the vertices sent by `dtfs`, by `linked`, and by `dtfs` on the level of as many
/// triangles, as fractions of three per triangle.
fn sent_by(built: &BuiltModel, view: &mut SkipView) -> Result<[f64; 4], Failure> {
    let of = |sent: usize, triangles: usize| sent as f64 / (3 * triangles).max(1) as f64;
    let count = view.triangle_count();
    let linked = Filter::Linked.strips(&view.simplified_strips());
    let mut uniform = built.model.view();
    uniform.set_level(built.model.levels().level_of_triangles(count))?;
    Ok([
        of(view.display_strips().vertices_sent(), count),
        of(linked.vertices_sent(), count),
        of(uniform.display_strips().vertices_sent(), uniform.triangle_count()),
        0.0,
    ])
}

/// The methods that compute strips from scratch.
const AGAIN: [Method; 3] = [Method::STRIPE, Method::Sequential, Method::Best];

/// Computes the strips of a frame from its triangles. Returns the milliseconds, and the vertices
/// sent as a fraction of three per triangle.
fn compute_again(mesh: &Mesh, view: &SkipView) -> Result<Vec<(Method, [f64; 2])>, Failure> {
    let triangles = view.renamed_triangles();
    let count = triangles.len();
    let drawn = Mesh::new(mesh.shared_positions(), Faces::from_triangles(triangles.into_flattened())?)?;
    AGAIN
        .into_iter()
        .map(|method| {
            let start = Instant::now();
            let strips = stripify(&drawn, &StripifyOptions::default().with_method(method))?;
            let milliseconds = 1e3 * start.elapsed().as_secs_f64();
            Ok((method, [milliseconds, strips.vertices_sent() as f64 / (3 * count).max(1) as f64]))
        })
        .collect()
}

/// Compares with the targets.
pub(super) fn compare(flown: &[FlightFigures]) -> Vec<Target> {
    let mut targets = Vec::new();
    for flown in flown {
        let Some(flight) = FLIGHTS.iter().find(|flight| flight.name == flown.name) else { continue };
        let name = flown.name;
        if let Some([dtfs, repaired]) = flight.most {
            targets.push(Target::at_most(format!("vertices sent by dtfs, {name}"), dtfs, flown.sent[0], 2));
            let what = format!("vertices sent by repaired strips, {name}");
            targets.push(Target::at_most(what, repaired, flown.sent[2], 2));
        }
        if flown.detail > DETAILED {
            for (method, most) in [(Method::STRIPE, 1.0 / 60.0), (Method::Sequential, 0.2)] {
                let again = flown.again.iter().find(|(other, ..)| *other == method);
                let ratio = flown.milliseconds / again.map_or(0.0, |again| again.1);
                let what = format!("update / computing the strips again by {method}, {name}");
                targets.push(Target::at_most(what, most, ratio, 4));
            }
        }
        if let Some(milliseconds) = flight.milliseconds {
            let what = format!("median ms of a frame, {name}");
            targets.push(Target::at_most(what, milliseconds, flown.milliseconds, 1));
        }
        let what = format!("worst frame / median, {name}");
        targets.push(Target::at_most(what, 3.0, flown.worst / flown.milliseconds, 1));
    }
    targets
}

/// Returns a row per flight.
pub(super) fn table(flown: &[FlightFigures]) -> Table {
    let heads = [
        "flight",
        "pixels",
        "triangles",
        "moved %",
        "looked at",
        "ms",
        "worst ms",
        "dtfs",
        "linked",
        "uniform",
        "repaired",
        "repaired ms",
    ];
    let mut table = Table::new(1, &heads);
    for flight in flown {
        let [dtfs, linked, repaired, uniform] = flight.sent.map(|sent| format!("{sent:.3}"));
        table.push(vec![
            flight.name.into(),
            flight.pixels.to_string(),
            format!("{:.0}", flight.triangles),
            format!("{:.2}", 100.0 * flight.moved),
            format!("{:.0}", flight.looked_at),
            format!("{:.2}", flight.milliseconds),
            format!("{:.2}", flight.worst),
            dtfs,
            linked,
            uniform,
            repaired,
            format!("{:.1}", flight.repair_milliseconds),
        ]);
    }
    table
}

/// Returns a row per flight with the strips from scratch.
pub(super) fn baselines(flown: &[FlightFigures]) -> Table {
    let heads = ["flight", "update ms", "stripe ms", "sent", "sequential ms", "sent", "best ms", "sent"];
    let mut table = Table::new(1, &heads);
    for flight in flown {
        let mut row = vec![flight.name.into(), format!("{:.2}", flight.milliseconds)];
        for (_, milliseconds, sent) in &flight.again {
            row.extend([format!("{milliseconds:.1}"), format!("{sent:.3}")]);
        }
        table.push(row);
    }
    table
}
