//! Plots as SVG text that is complete in itself: title and description for those who cannot see it, units on every axis, colours that
//! follow the viewer's light or dark setting. `draw` and those beside it take results of the contract, the other modules plain numbers
//! and labelled lines. Knows no HTTP and no file.

pub mod draw;
pub mod draw_rotor;
pub mod draw_uncertainty;

mod campbell;
mod loads;
mod map;
mod orbit;
mod orders;
mod series;
mod shapes;
mod spectrum;
mod trend;
mod uncertainty;
mod waterfall;
mod work_precision;

mod axis;
mod png;
mod shade;
mod svg;
mod varied_axis;

pub use svg::{Theme, seen};
pub use work_precision::{ErrorPanel, WorkPoint, WorkPrecisionCurve, work_precision_svg};
