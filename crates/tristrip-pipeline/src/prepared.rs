//! A model prepared for strips: the faces and the dual graph of each part. Methods, bounds and
//! measurements share them.
//!
//! Each stage processes all parts in parallel. Results are in the order of the parts for any number
//! of threads.

use tristrip::stripify::Watch;
use tristrip::text::counted;
use tristrip::verify::verify;
use tristrip::{DualGraph, Mesh, PreparedFaces, StripifyOptions, Strips, stripify};
use tristrip_io::Model;

use crate::error::Error;
use crate::figures::{MeshProperties, PartMetrics};
use crate::metrics::StripMetrics;
use crate::observer::{Observer, SearchStop, Stage, begin};
use crate::parts::{PreparedPart, map, meshes};
use crate::places::Places;

/// The prepared parts of a model, in their order. Memory: the prepared faces and the dual graphs.
///
/// ```
/// use tristrip::{Method, StripifyOptions};
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::PreparedModel;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let prepared = PreparedModel::new(&model, false);
/// let options = StripifyOptions::default().with_method(Method::SGI);
/// let strips = prepared.find_strips(&options, &())?;
/// prepared.prove(&strips)?;
/// assert_eq!(prepared.metrics(&strips, &options)?.vertices_sent, 4);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
#[derive(Debug)]
pub struct PreparedModel<'a> {
    parts: Vec<PreparedPart<'a>>,
    places: Places,
}

impl<'a> PreparedModel<'a> {
    /// Prepares the faces and builds the dual graph of each part. `weld` merges vertices with the
    /// same bits in all attributes.
    pub fn new(model: &'a Model, weld: bool) -> Self {
        Self { places: Places::of(model), ..Self::of_meshes(&meshes(model), weld) }
    }

    /// Prepares meshes of a model in their own coordinates.
    pub(crate) fn of_meshes(meshes: &[&'a Mesh], weld: bool) -> Self {
        let parts = map(meshes, |&mesh| {
            let surface = PreparedFaces::new(mesh, weld);
            let graph = DualGraph::new(surface.faces());
            PreparedPart { mesh, surface, graph }
        });
        Self { parts, places: Places::one(meshes.len()) }
    }

    /// Returns the parts in their order.
    pub fn parts(&self) -> &[PreparedPart<'a>] {
        &self.parts
    }

    /// Returns the transforms with which the model shows its parts.
    pub(crate) fn places(&self) -> &Places {
        &self.places
    }

    /// Counts faces, edges and vertices of all parts.
    pub fn mesh_figures(&self) -> MeshProperties {
        MeshProperties::of(&self.parts)
    }

    /// Builds the strips of each part, over its vertices. Searches report their progress to the
    /// watch. Vertices are welded if the model was prepared with welding.
    ///
    /// # Errors
    /// A part is too large, or an option has an invalid value.
    pub fn find_strips(&self, options: &StripifyOptions, watch: &dyn Watch) -> Result<Vec<Strips>, Error> {
        let found = map(&self.parts, |part| {
            Ok(stripify::plan_watched(&part.surface, &part.graph, options, watch)?.strips())
        });
        found.into_iter().collect()
    }

    /// Builds the strips of each part under the watch of an observer.
    pub(crate) fn search(
        &self,
        options: &StripifyOptions,
        observer: &dyn Observer,
    ) -> Result<(Vec<Strips>, Option<SearchStop>), Error> {
        begin(observer, Stage::Stripify)?;
        let watch = observer.search(options);
        let strips = self.find_strips(options, &*watch)?;
        let stopped = watch.stopped();
        drop(watch);
        Ok((strips, stopped))
    }

    /// Measures the strips of all parts.
    ///
    /// # Errors
    /// Strips refer to a vertex that their part does not have.
    pub fn metrics(&self, strips: &[Strips], options: &StripifyOptions) -> Result<StripMetrics, Error> {
        Ok(self.metrics_with_parts(strips, options)?.0)
    }

    /// Measures strips like [`PreparedModel::metrics`], and also returns the metrics of each part.
    pub(crate) fn metrics_with_parts(
        &self,
        strips: &[Strips],
        options: &StripifyOptions,
    ) -> Result<(StripMetrics, Vec<PartMetrics>), Error> {
        let vertex_counts = self.parts.iter().map(|part| part.mesh.vertex_count());
        StripMetrics::with_parts(&strips.iter().zip(vertex_counts).collect::<Vec<_>>(), options)
    }

    /// Verifies that the strips of each part draw its mesh, and that welded vertices are equal.
    ///
    /// # Errors
    /// [`Error::Unproven`], with the index of the part if there are several.
    pub fn prove(&self, strips: &[Strips]) -> Result<(), Error> {
        if strips.len() != self.parts.len() {
            let (found, expected) = (strips.len(), self.parts.len());
            return Err(Error::unproven(format!(
                "found strips of {}, expected {expected}",
                counted(found, "part")
            )));
        }
        let pairs: Vec<_> = self.parts.iter().zip(strips).collect();
        let proofs = map(&pairs, |(part, strips)| prove_part(part, strips));
        for (number, proof) in proofs.into_iter().enumerate() {
            proof.map_err(|why| match self.parts.len() {
                1 => Error::unproven(why),
                _ => Error::unproven(format!("part {number}: {why}")),
            })?;
        }
        Ok(())
    }
}

fn prove_part(part: &PreparedPart<'_>, strips: &Strips) -> Result<(), String> {
    verify(part.mesh, strips).map(drop).map_err(|why| why.to_string())
}

/// A prepared model with the report on its mesh. Every function of this crate that builds or bounds
/// strips creates one first.
#[derive(Debug)]
#[non_exhaustive]
pub(crate) struct Survey<'a> {
    /// The prepared model.
    pub prepared: PreparedModel<'a>,
    /// The options, adapted to the model: welding is disabled if vertices may differ in values that
    /// were not read.
    pub options: StripifyOptions,
    /// The vertex, edge and face counts of the mesh.
    pub mesh: MeshProperties,
    /// Notes of the reader, and notes on data that was dropped, changed or unusual.
    pub notes: Vec<String>,
}

impl<'a> Survey<'a> {
    /// Prepares a model for a method, and notifies the observer of each stage.
    ///
    /// # Errors
    /// The observer cancelled the operation.
    pub(crate) fn new(
        model: &'a Model,
        options: StripifyOptions,
        observer: &dyn Observer,
    ) -> Result<Self, Error> {
        let mut notes = model.notes.clone();
        let options = fitted(options, model, &mut notes);
        begin(observer, Stage::Prepare)?;
        let prepared = PreparedModel::new(model, options.weld);
        begin(observer, Stage::Survey)?;
        let mesh = prepared.mesh_figures();
        notes.extend(mesh.remarks());
        Ok(Self { prepared, options, mesh, notes })
    }
}

/// Returns the options adapted to a model. Welding is disabled, with a note, if vertices may differ
/// in values that were not read.
fn fitted(options: StripifyOptions, model: &Model, notes: &mut Vec<String>) -> StripifyOptions {
    if options.weld && tristrip_io::gltf::has_unread_vertex_values(model) {
        let why = "vertices may differ in morph targets or in attributes that were not decoded";
        notes.push(format!("not welded: {why}"));
        return options.with_weld(false);
    }
    options
}
