//! Compares all methods on one model. Each result is verified.

use serde::Serialize;
use tristrip::stripify::{
    Acceptance, FaceTriangulation, LastTie, Localization, Patches, Ties, TunnelOptions,
};
use tristrip::{Effort, Method, StripifyOptions};
use tristrip_io::Model;

use crate::error::Error;
use crate::figures::MeshProperties;
use crate::method::MethodDescription;
use crate::metrics::StripMetrics;
use crate::observer::{Observer, SearchStop, Stage, begin};
use crate::prepared::{PreparedModel, Survey};

/// Options for comparing methods.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Options {
    /// The options that all methods share, such as the seed. Their method is ignored.
    pub stripify: StripifyOptions,
    /// The effort of all methods that search, or `None` for their defaults; `best` also runs at its
    /// default effort.
    pub effort: Option<Effort>,
    /// Whether every variant of a method is compared, instead of one or a few per family.
    pub every_variant: bool,
}

impl Options {
    tristrip::setters! {
        /// Sets the options that all methods share.
        with_stripify(stripify: StripifyOptions);

        /// Sets the effort of the methods that search.
        with_effort(effort: Option<Effort>);

        /// Sets whether every variant of a method is compared.
        with_every_variant(every_variant: bool);
    }

    /// Returns the options of each row: `best` at its default effort, then all methods at the
    /// requested effort.
    ///
    /// ```
    /// use tristrip::Effort;
    /// use tristrip_pipeline::compare::Options;
    /// let every = Options::default().with_every_variant(true);
    /// let other = every.with_effort(Effort::new(3));
    /// // `best` gets a second row if the effort is not its default.
    /// assert_eq!((every.methods().len(), other.methods().len()), (45, 46));
    /// ```
    pub fn methods(&self) -> Vec<StripifyOptions> {
        let default = self.stripify.with_method(Method::Best);
        let all = methods_to_compare(self.every_variant).into_iter().map(|method| {
            let options = self.stripify.with_method(method);
            self.effort.map_or(options, |effort| options.with_effort(effort))
        });
        let is_default = |options: &StripifyOptions| {
            options.method == Method::Best && options.effort_or_default() == default.effort_or_default()
        };
        std::iter::once(default).chain(all.filter(|options| !is_default(options))).collect()
    }
}

/// The results of all methods on a model. The field names are the keys of the JSON report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The vertex, edge and face counts of the mesh.
    pub mesh: MeshProperties,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// Human-readable notes on data that was read, dropped, changed or unusual.
    pub notes: Vec<String>,
    /// One entry per method. If a search was interrupted, its entry is the last one.
    pub methods: Vec<Row>,
}

/// The result of one method.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Row {
    /// The method and its options.
    #[serde(flatten)]
    pub method: MethodDescription,
    /// Whether the strips draw exactly the faces of the model.
    pub proven: bool,
    /// The times of the method in seconds.
    pub seconds: MethodSeconds,
    /// The metrics of a verified result; `None` if there is none.
    #[serde(flatten)]
    pub metrics: Option<StripMetrics>,
    /// Why the search ended before its effort was spent; `None` if it was not stopped.
    pub stopped: Option<SearchStop>,
    /// Why there is no result; `None` if there is one.
    pub error: Option<String>,
}

/// The times of a method, in seconds; `None` for times that were not measured. The pipeline does
/// not read the clock: the caller fills them in.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MethodSeconds {
    /// The time to build the strips; `None` if it was not measured.
    pub stripify: Option<f64>,
    /// The time to verify the strips; `None` if it was not measured.
    pub verify: Option<f64>,
}

/// Builds strips by all methods, then measures and verifies them. If the result of a method fails
/// verification, its row has an error message. At the start of each method, the observer receives
/// [`Stage::Stripify`].
///
/// # Errors
/// The observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::compare;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let compared = compare::run(&model, &compare::Options::default(), &())?;
/// assert!(compared.methods.iter().all(|row| row.proven));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    let Survey { prepared, options: adapted, mesh, notes } = Survey::new(model, options.stripify, observer)?;
    let mut methods = Vec::new();
    for stripify in options.methods() {
        let row = row(&prepared, &stripify.with_weld(adapted.weld), observer)?;
        let is_interrupted = row.stopped == Some(SearchStop::Interrupt);
        methods.push(row);
        if is_interrupted {
            break;
        }
    }
    Ok(Outcome { mesh, parts: prepared.parts().len(), notes, methods })
}

/// Runs one method. Its row has metrics only if the result is verified.
fn row(
    prepared: &PreparedModel<'_>,
    options: &StripifyOptions,
    observer: &dyn Observer,
) -> Result<Row, Error> {
    begin(observer, Stage::Stripify)?;
    let watch = observer.search(options);
    let measured = prepared.find_strips(options, &*watch).and_then(|strips| {
        begin(observer, Stage::Prove)?;
        prepared.prove(&strips)?;
        begin(observer, Stage::Measure)?;
        prepared.metrics(&strips, options)
    });
    let stopped = watch.stopped();
    let (metrics, error) = match measured {
        Ok(metrics) => (Some(metrics), None),
        Err(Error::Cancelled) => return Err(Error::Cancelled),
        Err(error) => (None, Some(error.to_string())),
    };
    let (method, seconds) = (MethodDescription::of(options), MethodSeconds::default());
    Ok(Row { method, proven: metrics.is_some(), seconds, metrics, stopped, error })
}

/// The variant of `eta` in the comparison. With the default tunnel length, `eta` takes 15 minutes
/// for a million triangles.
const ETA_TO_COMPARE: Method = Method::Eta {
    tunnels: TunnelOptions::ETA.with_length(49),
    acceptance: Acceptance::DepthFirst,
    localization: Localization::OnDemand,
};

/// Returns the methods to compare: one or a few per family, or every variant.
fn methods_to_compare(every_variant: bool) -> Vec<Method> {
    let mut methods = vec![
        Method::Best,
        Method::Fewest,
        Method::Cache,
        Method::Input,
        Method::Sequential,
        Method::SGI,
        Method::QUAD_ROWS,
    ];
    let local = |triangulation, ties| Method::StripeLocal { triangulation, ties };
    let global = |patches, cutoff| Method::StripeGlobal { patches, cutoff, ties: Ties::default() };
    if every_variant {
        methods.extend([
            Method::TUNNEL,
            ETA_TO_COMPARE,
            Method::GuidedTunnels(TunnelOptions::default()),
            Method::Sgi { last_tie: LastTie::First },
        ]);
        for triangulation in FaceTriangulation::ALL {
            methods.extend(Ties::ALL.map(|ties| local(triangulation, ties)));
        }
        for patches in Patches::ALL {
            methods.extend([5, 10, 15, 20, 25].map(|cutoff| global(patches, cutoff)));
        }
    } else {
        methods.extend([
            local(FaceTriangulation::Static, Ties::Sequential),
            local(FaceTriangulation::Whole, Ties::Sequential),
            local(FaceTriangulation::Partial, Ties::Sequential),
            local(FaceTriangulation::Whole, Ties::LookAhead),
            global(Patches::Rows, 5),
            global(Patches::Full, 5),
        ]);
    }
    methods
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn all_variants_have_distinct_labels() {
        let label = |method| MethodDescription::of(&StripifyOptions::default().with_method(method)).label();
        let labels: HashSet<String> = methods_to_compare(true).into_iter().map(label).collect();
        assert_eq!(labels.len(), 7 + 4 + 24 + 10);
        for known in [
            "stripe-local",
            "stripe-local:triangulation=partial,ties=look-ahead",
            "stripe-global:patches=full,cutoff=25",
            "eta:tunnel-length=49",
        ] {
            assert!(labels.contains(known), "{known}");
        }
        assert!(methods_to_compare(false).into_iter().all(|method| labels.contains(&label(method))));
    }
}
