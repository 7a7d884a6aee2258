//! The source of a flight's cameras: a named path, or a file of cameras.

use std::path::{Path, PathBuf};

use tristrip::lod::Camera;

use super::lens::{Axis, Lens};
use super::path::FlightPath;
use crate::error::Error;

/// The source of a flight's cameras.
///
/// ```
/// use tristrip_lab::flight::{Axis, CameraPath, Lens};
/// let path = CameraPath::new("flyover".as_ref(), Some(Axis::Z))?;
/// assert_eq!((path.name(), path.cameras(&[[0.0; 3], [9.0, 5.0, 1.0]], 4, Lens::default())?.len()), ("flyover".into(), 4));
/// assert!(CameraPath::new("spiral".as_ref(), None).is_err());
/// # Ok::<(), tristrip_lab::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CameraPath {
    /// One turn around the model.
    Orbit(Axis),
    /// Straight toward the model.
    Dolly(Axis),
    /// Over the model. Without an axis, the shortest side of the model is vertical.
    Flyover(Option<Axis>),
    /// The cameras of a JSON file.
    File(PathBuf),
}

impl CameraPath {
    /// Parses the name of a path, or the name of a JSON file of cameras. `up` is the vertical axis;
    /// the default is y, except for a flyover.
    ///
    /// # Errors
    /// The text is neither, or an axis is given for a file.
    pub fn new(path: &Path, up: Option<Axis>) -> Result<Self, Error> {
        Ok(match path.to_str() {
            Some("orbit") => Self::Orbit(up.unwrap_or(Axis::Y)),
            Some("dolly") => Self::Dolly(up.unwrap_or(Axis::Y)),
            Some("flyover") => Self::Flyover(up),
            _ if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("json")) => {
                let expected = "expected orbit, dolly, flyover or a .json file of cameras";
                return Err(Error::Data(format!("path: found {}, {expected}", path.display())));
            }
            _ if up.is_some() => {
                let message = "up cannot be used with a file of cameras, which has its own up vectors";
                return Err(Error::Data(message.into()));
            }
            _ => Self::File(path.to_owned()),
        })
    }

    /// Returns the name for reports: that of the path, or of the file.
    pub fn name(&self) -> String {
        match self {
            Self::Orbit(_) => "orbit".into(),
            Self::Dolly(_) => "dolly".into(),
            Self::Flyover(_) => "flyover".into(),
            Self::File(path) => path.display().to_string(),
        }
    }

    /// Returns the cameras of `frame_count` frames over a model with these positions.
    ///
    /// # Errors
    /// The file cannot be read or has no valid cameras, the number of frames is 0 or exceeds
    /// [`MAX_FRAMES`](super::MAX_FRAMES), or there are no positions.
    pub fn cameras(
        &self,
        positions: &[[f32; 3]],
        frame_count: usize,
        lens: Lens,
    ) -> Result<Vec<Camera>, Error> {
        let named = |error| match error {
            Error::Data(text) => Error::Data(format!("path {}: {text}", self.name())),
            other => other,
        };
        self.over(positions).and_then(|path| path.cameras(frame_count, lens)).map_err(named)
    }

    /// Reads the file, if there is one, to report its errors before a model is built.
    ///
    /// # Errors
    /// The file cannot be read, or has no valid cameras.
    pub fn check(&self) -> Result<(), Error> {
        let Self::File(path) = self else { return Ok(()) };
        let text = std::fs::read_to_string(path).map_err(|error| Error::io(path, error))?;
        let read = FlightPath::from_json(&text);
        read.map(drop).map_err(|error| Error::Data(format!("{}: {error}", path.display())))
    }

    fn over(&self, positions: &[[f32; 3]]) -> Result<FlightPath, Error> {
        match self {
            Self::Orbit(up) => FlightPath::orbit(positions, *up),
            Self::Dolly(up) => FlightPath::dolly(positions, *up),
            Self::Flyover(up) => FlightPath::flyover(positions, *up),
            Self::File(path) => {
                let text = std::fs::read_to_string(path).map_err(|error| Error::io(path, error))?;
                FlightPath::from_json(&text)
            }
        }
    }
}
