//! The motion of rolling bearings: geometry, contacts, integrators, reduced models and the error of each result.
//!
//! A *scene* says what to simulate, *settings* say how. A run chooses the cheapest model that it can verify, and its result states
//! the error. The crate knows no JSON, no HTTP, no SQL and no thread pool.
//!
//! ```
//! use raceway_core::{Control, Outputs, Scene, Settings, presets, simulate};
//!
//! let bearing = presets::bearing("article-integrated").ok_or("no such bearing")?;
//! let speed = 50_000.0 * std::f64::consts::PI / 30.0; // 50 000 r/min in rad/s
//! let scene = Scene::of_preset(&bearing, speed, [0.0, 200.0, 0.0]).map_err(|faults| format!("{faults:?}"))?;
//! let settings = Settings::new(0.005, 0.01, Outputs::vibration());
//! let result = simulate(&scene, &settings, &Control::until(&|| false))?;
//! for (channel, metrics) in &result.summary.channels {
//!     println!("{channel}: level {:?} dB", metrics.level_db);
//! }
//! # assert!(result.summary.channels.iter().any(|(_, metrics)| metrics.level_db.is_some_and(f64::is_finite)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The names at the root are those that a user of the crate needs; they rest on the types of their fields. Everything else in the
//! modules is unstable: internal to the service.

/// A flexible shaft on ball bearings, in time. Unstable: internal to the service.
pub mod machine;
/// A measured signal beside a prediction: resampling, spectra, lines. Unstable: internal to the service.
pub mod measured;
/// Mathematics: integrators, spectra, special functions. Knows no bearing. Unstable: internal to the service.
pub mod numerics;
/// Signals at a varying speed: order spectra, order tracks, waterfalls. Unstable: internal to the service.
pub mod orders;
/// The bearing: contacts, bodies, forces. Knows no clock and no JSON. Its formulas are unstable: internal to the service.
pub mod physics;
/// A shaft on its supports, linear: natural frequencies, critical speeds, response. Unstable: internal to the service.
pub mod rotor;
/// Uncertain inputs: distributions, designs, percentiles, shares of the variance. Unstable: internal to the service.
pub mod sampling;
/// The motion: scene, model, equilibrium, run, recording. Unstable: internal to the service.
pub mod simulation;
/// Many runs: the points of a grid, and trends and optima over them. Unstable: internal to the service.
pub mod study;

pub use numerics::ode::Method;
pub use physics::{InvalidParameter, presets};
pub use simulation::input::channel::Channel;
pub use simulation::input::control::Control;
pub use simulation::input::model_level::ModelLevel;
pub use simulation::input::scene::{Scene, SceneParameters};
pub use simulation::input::settings::{Outputs, RunSettings as Settings};
pub use simulation::model::failure::SimulationError;
pub use simulation::result::run_result::RunResult;
pub use simulation::solve::run::simulate;
