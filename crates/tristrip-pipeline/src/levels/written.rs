//! Encodes levels and views as files.

use tristrip::Strips;
use tristrip_io::{Drawing, Model};

use super::part::without_unused;
use super::{DisplayedLevel, DisplayedView, ModelLevels};
use crate::encode::{self, kept_vertices};
use crate::error::Error;
use crate::observer::Observer;

impl ModelLevels {
    /// Encodes a level as a file that draws its display strips over the vertices that they use, and
    /// verifies the bytes.
    ///
    /// # Errors
    /// The level belongs to another model, the format cannot store it, the bytes fail verification,
    /// or the observer cancelled the operation.
    pub fn encode(
        &self,
        model: &Model,
        displayed: &DisplayedLevel,
        options: &encode::Options,
        observer: &dyn Observer,
    ) -> Result<encode::Outcome, Error> {
        let levels = self.parts.iter().zip(&displayed.of_parts);
        let triangles = levels.map(|(part, &level)| part.triangles(level)).collect::<Result<Vec<_>, _>>()?;
        self.encode_drawn(model, (&displayed.strips, triangles), *options, observer)
    }

    /// Encodes a view of the model like [`ModelLevels::encode`].
    ///
    /// # Errors
    /// The view belongs to another model, the format cannot store it, the bytes fail verification,
    /// or the observer cancelled the operation.
    pub fn encode_view(
        &self,
        model: &Model,
        view: &DisplayedView,
        options: &encode::Options,
        observer: &dyn Observer,
    ) -> Result<encode::Outcome, Error> {
        self.encode_drawn(model, (&view.strips, view.triangles.clone()), *options, observer)
    }

    /// Encodes display strips over the vertices of the collapses, and the triangles that they draw
    /// over the vertices of the model.
    fn encode_drawn(
        &self,
        model: &Model,
        (strips, triangles): (&[Strips], Vec<Vec<u32>>),
        options: encode::Options,
        observer: &dyn Observer,
    ) -> Result<encode::Outcome, Error> {
        let drawn = self.parts.iter().zip(strips).zip(&triangles);
        let outward = drawn.map(|((part, strips), drawn)| {
            Ok(without_unused(&part.outward(strips)?, drawn, part.vertex_count()))
        });
        let strips = outward.collect::<Result<Vec<Strips>, Error>>()?;
        let smaller = tristrip_io::with_triangles(model, triangles, options.format)?;
        let strips = strips.iter().enumerate().map(|(part, strips)| Ok(smaller.strips(part, strips)?));
        let strips: Vec<Strips> = strips.collect::<Result<_, Error>>()?;
        let drawings: Vec<_> = strips.iter().map(Drawing::Strips).collect();
        let mut notes = kept_vertices(&smaller);
        let encoded = encode::run(&smaller.model, &drawings, &options, observer)?;
        notes.extend(encoded.notes);
        Ok(encode::Outcome { notes, ..encoded })
    }
}
