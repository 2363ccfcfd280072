//! Pictures from results, as SVG text that stands alone: title and description for those who cannot see it, units on
//! every axis, colours that follow the viewer's light or dark setting. Takes plain numbers and labelled lines; knows
//! no HTTP, no file, and not where a result comes from.

mod loads;
mod map;
mod orbit;
mod series;
mod spectrum;
mod trend;
mod work_precision;

mod axis;
mod svg;

pub use loads::{LoadCurve, loads_svg};
pub use map::{MapPanel, map_svg};
pub use orbit::{OrbitCurve, orbit_svg};
pub use series::{SeriesCurve, series_svg};
pub use spectrum::{SpectrumCurve, spectrum_svg};
pub use trend::{AxisPlaces, TrendCurve, TrendPanel, VariedAxis, trend_svg};
pub use work_precision::{ErrorPanel, FailedRun, WorkPoint, WorkPrecisionCurve, work_precision_svg};
