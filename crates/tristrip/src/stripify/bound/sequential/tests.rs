use proptest::prelude::*;

use super::super::tests::graph;
use super::*;
use crate::dual::Triangulation;
use crate::mesh::{Faces, Mesh};
use crate::prepare::PreparedFaces;
use crate::strip::{emit, path_cost};
use crate::verify::verify;

/// Returns the number of vertices of the best strip without a swap, if there is one, by trying
/// every triangle, exit and side of the first turn.
fn least_vertices_without_swap(graph: &DualGraph) -> Option<usize> {
    let n = graph.face_count();
    let edge = |h: u32, by: u32| h - h % 3 + (h % 3 + by) % 3;
    let mut best = None;
    for start in 0..3 * n as u32 {
        for first_turn in [1, 2] {
            let mut seen = vec![start / 3];
            let mut out = start;
            let mut turn = first_turn;
            while let Some(twin) = graph.twin(HalfEdge(out)).filter(|twin| !seen.contains(&(twin.0 / 3))) {
                seen.push(twin.0 / 3);
                out = edge(twin.0, turn);
                turn = 3 - turn;
            }
            if seen.len() == n {
                // The second triangle may turn toward the previous edge for free.
                let sent = n + 2 + usize::from(n > 2 && first_turn == 1);
                best = Some(best.map_or(sent, |best: usize| best.min(sent)));
            }
        }
    }
    best
}

fn check(graph: &DualGraph) -> Result<(), TestCaseError> {
    let n = graph.face_count();
    let found = sequential_strip(graph);
    if let Some(strip) = &found {
        prop_assert_eq!(strip.cover.check(graph), Ok(()));
        prop_assert_eq!(strip.cover.path_count(), 1);
        let start = strip.cover.path_starts(graph).next().unwrap();
        prop_assert_eq!(path_cost(graph, &strip.cover, start), n + 3 - usize::from(strip.keeps_winding));
    }
    let sent = found.map(|strip| n + 3 - usize::from(strip.keeps_winding));
    prop_assert_eq!(sent, least_vertices_without_swap(graph));
    Ok(())
}

/// Builds the dual graph of a strip's triangles. The last vertices may repeat the first ones.
fn strip(vertices: &[u32]) -> DualGraph {
    let corners = vertices
        .windows(3)
        .enumerate()
        .flat_map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] });
    DualGraph::new(&Faces::from_triangles(corners.collect()).unwrap())
}

proptest! {
    #[test]
    fn finds_the_best_of_all_starts(graph in graph(1..9)) {
        check(&graph)?;
    }

    #[test]
    fn finds_strips_over_few_vertices(vertices in prop::collection::vec(0..7_u32, 3..12)) {
        // Any sequence without immediate repeats, including strips that meet themselves.
        let mut distinct: Vec<u32> = Vec::new();
        for v in vertices {
            if !distinct.iter().rev().take(2).any(|&last| last == v) {
                distinct.push(v);
            }
        }
        if distinct.len() > 2 {
            check(&strip(&distinct))?;
        }
    }
}

/// Returns the minimum number of runs that cover the triangles, by trying every run that contains
/// the first remaining triangle.
fn least_runs(all: &[u32], left: u32) -> usize {
    if left == 0 {
        return 0;
    }
    let first = 1 << left.trailing_zeros();
    let taking = all.iter().filter(|&&run| run & first != 0 && run & !left == 0);
    1 + taking.map(|&run| least_runs(all, left & !run)).min().unwrap_or(0)
}

proptest! {
    #[test]
    fn no_cover_has_fewer_runs(graph in graph(1..9)) {
        let n = graph.face_count();
        // All runs, as sets of triangles: from every entry, to either side, of any length.
        let mut all = Vec::new();
        for start in 0..3 * n as u32 {
            for is_odd in [false, true] {
                let mut run = 0;
                let mut state = Some((start, is_odd));
                while let Some(here) = state.filter(|here| run >> (here.0 / 3) & 1 == 0) {
                    run |= 1_u32 << (here.0 / 3);
                    all.push(run);
                    state = next(&graph, here);
                }
            }
        }
        all.sort_unstable();
        all.dedup();
        let found = runs(&graph, &vec![0; n], &[n])[0].least;
        let least = least_runs(&all, (1 << n) - 1);
        prop_assert!((1..=least).contains(&found), "{found} > {least}");
    }
}

#[test]
fn rows_of_a_grid_are_its_runs() {
    // Four rows of six squares. The longest runs are the rows; runs along the diagonal are shorter.
    let corner = |x: u32, y: u32| 7 * y + x;
    let squares = (0..4).flat_map(|y| (0..6).map(move |x| (x, y)));
    let corners = squares.flat_map(|(x, y)| {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        [a, b, c, a, c, d]
    });
    let graph = DualGraph::new(&Faces::from_triangles(corners.collect()).unwrap());
    assert_eq!(runs(&graph, &[0; 48], &[48])[0].least, 4);
}

#[test]
fn closed_rows_are_strips_of_any_start() {
    for n in 4..12_u32 {
        let ring: Vec<u32> = (0..n + 2).map(|i| i % n).collect();
        let graph = strip(&ring);
        assert!(check(&graph).is_ok());
        let found = sequential_strip(&graph).unwrap();
        assert!(found.keeps_winding);
        assert_eq!(found.is_closed, n % 2 == 0, "{n}");
    }
}

#[test]
fn empty_and_polygon_meshes_have_no_strip() {
    assert_eq!(sequential_strip(&DualGraph::new(&Faces::from_triangles(Vec::new()).unwrap())), None);
    let polygon = DualGraph::new(&Faces::from_polygons([[0, 1, 2, 3]]).unwrap());
    assert_eq!(sequential_strip(&polygon), None);
}

/// A gadget of the paper's section 5: a polygon of corners 1 to n around the vertex 0, triangulated
/// except for one pentagon, and the oriented edges over which its two sequential triangulations are
/// entered and left.
struct Gadget {
    name: &'static str,
    obj: &'static str,
    ways: [([u32; 2], [u32; 2]); 2],
}

/// Lemmas 1 and 2 for n = 4 and 5, constructed from their statements, because the paper shows them
/// only as drawings. An exhaustive search finds no others, except another first way for n = 5 that
/// has less in common with the second.
const GADGETS: [Gadget; 4] = [
    Gadget {
        name: "lemma 1, n = 4",
        obj: include_str!("../../../../../../testdata/gadgets/lemma1_n4.obj"),
        ways: [([1, 2], [1, 4]), ([1, 2], [3, 2])],
    },
    Gadget {
        name: "lemma 1, n = 5",
        obj: include_str!("../../../../../../testdata/gadgets/lemma1_n5.obj"),
        ways: [([1, 2], [4, 5]), ([1, 2], [2, 3])],
    },
    Gadget {
        name: "lemma 2, n = 4",
        obj: include_str!("../../../../../../testdata/gadgets/lemma2_n4.obj"),
        ways: [([1, 2], [1, 4]), ([3, 4], [1, 4])],
    },
    Gadget {
        name: "lemma 2, n = 5",
        obj: include_str!("../../../../../../testdata/gadgets/lemma2_n5.obj"),
        ways: [([1, 2], [4, 5]), ([3, 4], [4, 5])],
    },
];

/// Reads the faces of a gadget and the positions of its vertices. The inner vertex, the last one of
/// the file, becomes vertex 0.
fn read(obj: &str) -> (Vec<Vec<u32>>, Vec<[f64; 2]>) {
    fn numbers<T: std::str::FromStr<Err: std::fmt::Debug>>(line: &str) -> Vec<T> {
        line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect()
    }
    let mut positions: Vec<[f64; 2]> =
        obj.lines().filter(|l| l.starts_with("v ")).map(numbers).map(|v| [v[0], v[1]]).collect();
    let count = positions.len() as u32;
    let faces = obj.lines().filter(|l| l.starts_with("f "));
    let faces = faces.map(|l| numbers(l).into_iter().map(|v: u32| v % count).collect()).collect();
    positions.rotate_right(1);
    (faces, positions)
}

/// Returns all triangulations of a polygon.
fn triangulations(polygon: &[u32]) -> Vec<Vec<[u32; 3]>> {
    let n = polygon.len();
    if n < 3 {
        return vec![Vec::new()];
    }
    // The triangle at the edge from the last corner to the first, and the polygons on its two
    // sides.
    let apexes = 1..n - 1;
    apexes
        .flat_map(|i| {
            let (left, right) = (triangulations(&polygon[..=i]), triangulations(&polygon[i..]));
            let triangle = [polygon[n - 1], polygon[0], polygon[i]];
            left.into_iter()
                .flat_map(move |l| right.clone().into_iter().map(move |r| [&l[..], &[triangle], &r].concat()))
        })
        .collect()
}

/// Returns whether a strip of vertices draws each of the triangles once. Any winding is accepted,
/// because a strip entered over a given edge may have to reverse it.
fn draws(strip: &[u32], triangles: &[[u32; 3]]) -> bool {
    let sorted = |w: &[u32]| {
        let mut t = [w[0], w[1], w[2]];
        t.sort_unstable();
        t
    };
    let mut drawn: Vec<[u32; 3]> = strip.windows(3).map(sorted).collect();
    let mut wanted: Vec<[u32; 3]> = triangles.iter().map(|t| sorted(t)).collect();
    drawn.sort_unstable();
    wanted.sort_unstable();
    drawn == wanted
}

/// Returns whether a sequential strip can enter over one oriented edge and leave over another, by
/// trying all vertex sequences.
fn has_way(triangles: &[[u32; 3]], enter: [u32; 2], leave: [u32; 2]) -> bool {
    let vertex_count = 1 + triangles.iter().flatten().max().unwrap();
    let between = triangles.len() as u32 - 2;
    (0..vertex_count.pow(between)).any(|code| {
        let middle = (0..between).map(|i| code / vertex_count.pow(i) % vertex_count);
        let strip: Vec<u32> = enter.into_iter().chain(middle).chain(leave).collect();
        draws(&strip, triangles)
    })
}

#[test]
fn gadgets_have_the_two_ways_of_their_lemmas() {
    for gadget in GADGETS {
        let (faces, positions) = read(gadget.obj);
        let n = positions.len() - 1;
        let (cut, pentagons): (Vec<_>, Vec<_>) = faces.into_iter().partition(|face| face.len() == 3);
        assert_eq!(pentagons.len(), 1, "{}", gadget.name);
        let cut: Vec<[u32; 3]> = cut.iter().map(|t| [t[0], t[1], t[2]]).collect();
        let all: Vec<Vec<[u32; 3]>> =
            triangulations(&pentagons[0]).into_iter().map(|rest| [&cut[..], &rest].concat()).collect();
        assert_eq!(all.len(), 5);
        for (enter, leave) in gadget.ways {
            let with_way: Vec<_> = all.iter().filter(|t| has_way(t, enter, leave)).collect();
            assert_eq!(with_way.len(), 1, "{}: {enter:?} to {leave:?}", gadget.name);
            let triangles = with_way[0];
            assert_eq!(triangles.len(), n);
            // It is also a triangulation in the plane: all triangles have the same orientation.
            for [a, b, c] in triangles.iter().map(|t| t.map(|v| positions[v as usize])) {
                assert!((b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0]), "{}", gadget.name);
            }
            let faces = Faces::from_triangles(triangles.iter().flatten().copied().collect()).unwrap();
            let mesh = Mesh::new(vec![[0.0; 3]; n + 1], faces).unwrap();
            let prepared = PreparedFaces::new(&mesh, false);
            let graph = DualGraph::new(prepared.faces());
            let found = sequential_strip(&graph).unwrap();
            let strips = emit(&Triangulation::fan(&prepared, &graph), &found.cover);
            assert!(verify(&mesh, &strips).is_ok());
            assert_eq!(strips.vertices_sent(), n + 3 - usize::from(found.keeps_winding));
            assert!(check(&graph).is_ok());
        }
    }
}
