//! The runner: measures each requested recipe on each requested model.
//!
//! First all measurements are requested. Then every model is read once and all its measurements are
//! taken. After that the results are available. A model that is missing in the directory has none.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use tristrip_io::{Format, Model};

use super::measured::{Extras, MeasuredModel};
use super::observer::ReproObserver;
use super::paper::ModelSet;
use super::recipe::Recipe;
use super::view_data::TreeOrder;
use super::view_figures::ViewRequests;
use crate::error::Error;
use tristrip_io::system_message;

/// The models for each kind of measurement.
#[derive(Debug, Default)]
struct ModelScope {
    all: bool,
    polygons: bool,
    names: BTreeSet<String>,
    /// Models for which generalized triangle meshes are also measured.
    generalized: BTreeSet<String>,
    /// Models for which levels of detail are also measured.
    levels: BTreeSet<String>,
    /// Models for which the recovery of all levels is also measured.
    recovery: BTreeSet<String>,
    /// Models for which components are also measured.
    components: BTreeSet<String>,
    /// Models for which Skip Strips are also measured, by the order of their merge trees.
    views: BTreeMap<String, BTreeMap<TreeOrder, ViewRequests>>,
}

impl ModelScope {
    fn contains(&self, name: &str, has_polygons: bool) -> bool {
        self.all || (self.polygons && has_polygons) || self.names.contains(name)
    }

    fn extras(&self, name: &str) -> Extras {
        Extras {
            generalized: self.generalized.contains(name),
            levels: self.levels.contains(name),
            recovery: self.recovery.contains(name),
            components: self.components.contains(name),
            views: self.views.get(name).cloned().unwrap_or_default(),
        }
    }
}

/// The models of a directory, the requests and the measurements.
#[derive(Debug)]
pub(crate) struct Runner {
    models: BTreeMap<String, PathBuf>,
    requested: BTreeMap<Recipe, ModelScope>,
    requested_meshes: ModelScope,
    measured: BTreeMap<String, MeasuredModel>,
}

impl Runner {
    /// Lists the models of a directory.
    ///
    /// # Errors
    /// The directory cannot be read.
    pub(crate) fn new(folder: &Path) -> Result<Self, Error> {
        let entries = std::fs::read_dir(folder).map_err(|error| Error::io(folder, error))?;
        let mut paths = Vec::new();
        for entry in entries {
            let path = entry.map_err(|error| Error::io(folder, error))?.path();
            if Format::from_path(&path).is_some() {
                paths.push(path);
            }
        }
        // If two files have the same stem, the first one by name is used.
        paths.sort_unstable_by(|a, b| b.cmp(a));
        let named = |path: PathBuf| Some((path.file_stem()?.to_str()?.to_owned(), path));
        Ok(Self {
            models: paths.into_iter().filter_map(named).collect(),
            requested: BTreeMap::new(),
            requested_meshes: ModelScope::default(),
            measured: BTreeMap::new(),
        })
    }

    /// Requests the strips of a recipe for a model.
    pub(super) fn request(&mut self, recipe: Recipe, model: &str) {
        self.requested.entry(recipe).or_default().names.insert(model.into());
        self.request_mesh(model);
    }

    /// Requests the strips of a recipe as generalized triangle meshes, for vertex caches of all
    /// sizes.
    pub(super) fn request_generalized(&mut self, recipe: Recipe, model: &str) {
        self.requested.entry(recipe.clone()).or_default().generalized.insert(model.into());
        self.request(recipe, model);
    }

    /// Requests the levels of detail of a model, drawn with the strips of a recipe.
    pub(super) fn request_levels(&mut self, recipe: Recipe, model: &str) {
        self.requested.entry(recipe.clone()).or_default().levels.insert(model.into());
        self.request(recipe, model);
    }

    /// Requests the recovery of all levels of a model, over the strips of a recipe.
    pub(super) fn request_recovery(&mut self, recipe: Recipe, model: &str) {
        self.requested.entry(recipe.clone()).or_default().recovery.insert(model.into());
        self.request(recipe, model);
    }

    /// Requests the merge tree of a model over the strips of a recipe. Returns the requests for its
    /// views.
    pub(super) fn request_views(
        &mut self,
        recipe: Recipe,
        model: &str,
        order: TreeOrder,
    ) -> &mut ViewRequests {
        self.request(recipe.clone(), model);
        let views = &mut self.requested.entry(recipe).or_default().views;
        views.entry(model.into()).or_default().entry(order).or_default()
    }

    /// Requests the strips of a recipe, and the components that one strip draws.
    pub(super) fn request_components(&mut self, recipe: Recipe, model: &str) {
        self.requested.entry(recipe.clone()).or_default().components.insert(model.into());
        self.request(recipe, model);
    }

    /// Requests the strips of a recipe for a set of models. The models of tables are requested
    /// individually instead.
    pub(super) fn request_set(&mut self, recipe: Recipe, set: ModelSet) {
        let scope = self.requested.entry(recipe).or_default();
        match set {
            ModelSet::All => scope.all = true,
            ModelSet::Polygons => scope.polygons = true,
            ModelSet::Table | ModelSet::Own => return,
        }
        self.requested_meshes.all = true;
    }

    /// Requests the metrics of a mesh.
    pub(super) fn request_mesh(&mut self, model: &str) {
        self.requested_meshes.names.insert(model.into());
    }

    /// Takes all requested measurements. Returns the models that could not be read, each with the
    /// reason.
    ///
    /// # Errors
    /// Strips are not proven, flags are invalid, or the user interrupts.
    pub(super) fn measure(&mut self, observer: &dyn ReproObserver) -> Result<Vec<String>, Error> {
        let mut notes = Vec::new();
        let requested = |name: &String| self.requested_meshes.contains(name, false);
        let models: Vec<_> = self.models.iter().filter(|(name, _)| requested(name)).collect();
        let count = models.len();
        for (index, (name, path)) in models.into_iter().enumerate() {
            observer.model(&format!("{name} ({} of {count})", index + 1));
            let recipes = |has_polygons| {
                let scopes = self.requested.iter().filter(|(_, scope)| scope.contains(name, has_polygons));
                scopes.map(|(recipe, scope)| (recipe, scope.extras(name))).collect()
            };
            let measured = match read(path) {
                Ok(model) => MeasuredModel::measure(&model, name, recipes, observer),
                Err(why) => {
                    observer.model_done();
                    notes.push(format!("{name}: {why}"));
                    continue;
                }
            };
            observer.model_done();
            self.measured.insert(name.clone(), measured?);
        }
        Ok(notes)
    }

    /// Returns the measurements of a model.
    pub(super) fn model(&self, name: &str) -> Option<&MeasuredModel> {
        self.measured.get(name)
    }

    /// Iterates over the measured models, by name.
    pub(super) fn models(&self) -> impl Iterator<Item = (&str, &MeasuredModel)> {
        self.measured.iter().map(|(name, measured)| (name.as_str(), measured))
    }
}

/// Reads a model. If it cannot be read, returns the reason without the file name.
fn read(path: &Path) -> Result<Model, String> {
    tristrip_io::read_path(path).map_err(|error| match error {
        tristrip_io::Error::Io { path: at, source } if at == path.display().to_string() => {
            system_message(&source)
        }
        tristrip_io::Error::Io { path, source } => format!("{path}: {}", system_message(&source)),
        other => other.to_string(),
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use tristrip::vertex_cache::{FlushPolicy, Replacement};

    /// Measures models of `testdata`. `request` makes the requests.
    fn measured(request: impl FnOnce(&mut Runner)) -> Runner {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
        let mut runner = Runner::new(&folder).unwrap();
        request(&mut runner);
        assert_eq!(runner.measure(&()).unwrap(), Vec::<String>::new());
        runner
    }

    /// Measures the strips of `sgi` on models of `testdata`.
    pub(in crate::repro) fn measured_sgi(names: &[&str]) -> Runner {
        measured(|runner| names.iter().for_each(|name| runner.request("--method sgi".into(), name)))
    }

    #[test]
    fn exactly_what_is_requested_is_measured() {
        let stripe = Recipe::from("--method stripe");
        let runner = measured(|runner| {
            runner.request(stripe.clone(), "hand");
            runner.request_generalized("--method sgi".into(), "fish_control");
            runner.request("--method sgi".into(), "nobody");
        });
        assert_eq!(runner.models().map(|(name, _)| name).collect::<Vec<_>>(), ["fish_control", "hand"]);
        let (fish, hand) = (runner.model("fish_control").unwrap(), runner.model("hand").unwrap());
        assert!(fish.has_polygons && !hand.has_polygons && runner.model("nobody").is_none());
        assert_eq!((hand.size.triangles, hand.size.vertices), (15_982, 7993));
        assert_eq!(hand.strips(&"--method sgi".into(), "strips"), None);
        assert!(
            hand.strips(&stripe, "strips").unwrap() > 10.0
                && hand.transmitted(&stripe, Replacement::Lru, FlushPolicy::Keep).is_empty()
        );
        // A vertex cache of two entries has the GL cost.
        let sgi = Recipe::from("--method sgi");
        let transmitted = fish.transmitted(&sgi, Replacement::Lru, FlushPolicy::Flush);
        assert_eq!(Some(transmitted[0]), fish.strips(&sgi, "gl_cost"));
        assert!(transmitted.is_sorted_by(|a, b| a >= b) && transmitted.len() == 63);
    }
}
