//! Camera flights over a view-dependent model: what each frame draws and changes, and what it
//! costs.
//!
//! ```text
//! positions ─▶ FlightPath: orbit, dolly, flyover, or cameras of a JSON file ─▶ camera per frame
//! SkipStrips ─▶ view ─ update by each camera ─┬▶ FrameRow: triangles, vertices sent, changes, time
//!                                             │    └▶ FlightSummary ─▶ Markdown, chart (SVG)
//!                                             └▶ proof of some frames: display strips = triangles
//! ```
//! The time of a frame is the time of [`SkipView::update`](tristrip::lod::SkipView::update):
//! evaluation of the criteria, collapses and splits, and the changed display strips. Drawing and
//! the upload of changed ranges to the GPU are not measured.
//!
//! The first frame starts from the base mesh. It is reported separately. Medians and maxima cover
//! the frames after it.
//!
//! # References
//! El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and Updating Triangle
//! Strips for Real-Time Rendering*, 2000. Section 6 reports flights in the same quantities.

mod cameras;
mod chart;
mod extent;
mod frames;
mod lens;
mod path;
mod report;

pub use cameras::CameraPath;
pub use chart::draw;
pub(crate) use frames::is_among;
pub use frames::{
    FlightObserver, FlightOptions, FlightReport, FlightSummary, FrameRow, FrameSeconds, FrameValues, fly,
};
pub use lens::{Axis, Lens};
pub(crate) use path::Stop;
pub use path::{FlightPath, MAX_FRAMES};
pub use report::{as_markdown, as_text};
