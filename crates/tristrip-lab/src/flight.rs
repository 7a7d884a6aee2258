//! Flights of a camera over a view-dependent model: what each frame draws, changes and costs.
//!
//! ```text
//! positions ─▶ FlightPath: orbit, dolly, flyover, or cameras from a JSON file ─▶ cameras, one per frame
//! SkipStrips ─▶ view ─ update by the camera of each frame ─▶ FrameRow: triangles, vertices sent, changes, time
//!                 └── display strips = renamed triangles? proof of some frames     └▶ FlightSummary ─▶ Markdown, chart (SVG)
//! ```
//! The time of a frame is that of [`SkipView::update`](tristrip::lod::SkipView::update): the
//! criteria, the collapses and splits, and the display strips that they change. Drawing is not
//! measured, nor is the copy of the changed ranges to a graphics processor.
//!
//! The first frame comes from the base mesh. It is reported by itself; medians and worst values are
//! those of the frames after it.
//!
//! # References
//! El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: *Efficiently Computing and Updating Triangle
//! Strips for Real-Time Rendering*, 2000, section 6, reports flights in the same quantities.

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
