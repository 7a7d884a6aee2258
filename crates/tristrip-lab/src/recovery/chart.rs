//! The chart of recovery times: one panel per input and sweep, one line per level model.

use super::{ModelRecovery, Sweep};
use crate::error::Error;
use tristrip_render::chart::{Axis, Mark, Panel, Scale, Series, svg};

/// Draws a panel per input and sweep, from the name and the measurements of each input.
///
/// # Errors
/// The drawing library fails; no input is known that causes this.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_lab::recovery::{Sweep, draw, measure};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let levels = tristrip_pipeline::levels::run(&model, &Default::default(), &())?.model;
/// let measured = measure(&levels, &[Sweep::Linear], 1)?;
/// assert!(draw(&[("square".into(), &measured)])?.starts_with("<svg"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw(inputs: &[(String, &[ModelRecovery])]) -> Result<String, Error> {
    let mut panels = Vec::new();
    for (name, measured) in inputs {
        let has =
            |sweep: Sweep| measured.iter().any(|model| model.tests.iter().any(|test| test.sweep == sweep));
        panels.extend(
            Sweep::ALL.into_iter().filter(|&sweep| has(sweep)).map(|sweep| panel(name, measured, sweep)),
        );
    }
    Ok(svg(&panels, 1)?)
}

fn panel(name: &str, measured: &[ModelRecovery], sweep: Sweep) -> Panel {
    let series = |model: &ModelRecovery| {
        let tests = model.tests.iter().filter(|test| test.sweep == sweep);
        let points = tests.map(|test| (test.share as f64, test.microseconds)).collect();
        Series::new(&model.model, Mark::Line, points)
    };
    Panel::new(
        &format!("Recovery time, {sweep} sweep: {name}"),
        Axis::new("levels recovered, percent", Scale::Linear { from_zero: true }),
        Axis::new("microseconds per move", Scale::Log10),
        measured.iter().map(series).collect(),
    )
}
