//! Thresholds of error estimation and acceptance that several files use, in one table: meaning, unit, and the command that measured each. A
//! threshold of one file stands in that file.
//!
//! Commands: *drawn* = `cargo bench --bench calibration -- drawn`, *settling* = `cargo bench --bench calibration -- settling`,
//! *steps* = `cargo bench --bench fixed_steps`, *limits* = `cargo test --release --test limits`,
//! *tilt* = `benches/compare/tilt.py`.

/// Window of a verification against a richer model, and settling time before it [s]; *drawn*. After 2 ms, a window of 6 ms showed only a fifth of
/// the 0.1 dB by which single levels deviated.
pub const WINDOW_S: f64 = 12e-3;
pub const WINDOW_SETTLE_S: f64 = 10e-3;
/// Share of a short run that its window and settling time take [-], and their shortest values [s].
pub const WINDOW_RUN_SHARE: f64 = 0.1;
pub const MIN_WINDOW_S: f64 = 6e-3;
pub const MIN_WINDOW_SETTLE_S: f64 = 2e-3;
/// Ball passages in a window of verification [-]; *drawn*.
pub const WINDOW_PASSAGES: f64 = 3.0;
/// Turns of the cage in a window that shows whether neighbouring trajectories diverge [-]; *drawn*.
pub const DIVERGENCE_CAGE_TURNS: f64 = 1.0;

/// Largest scatter of a stationary level along the recorded time, one standard deviation [dB]; *drawn*. Periodic motion has less.
pub const STATIONARY_SCATTER_DB: f64 = 0.1;
/// Recorded time from which its own parts show every beat [s]; *drawn*.
pub const LONG_RECORD_S: f64 = 2.0;
/// Acceleration of a level of −20 dB re 9.81 mm/s² [m/s²]. Sensors on machines do not resolve it; its changes along a run are no fault of the run.
pub const QUIET: f64 = 9.81e-4;
/// Scatter of a level that the stated error has to cover [dB], and change along the recorded time that counts as a trend; *settling*.
pub const NOTABLE_CHANGE_DB: f64 = 0.5;
/// Scatter of a level about its straight line, as a share of a trend [-]; *settling*.
pub const TREND_RESIDUAL: f64 = 0.25;
/// If a second window reproduces the level within this share of its trend, the trend is an oscillation [-]; *settling*.
pub const OSCILLATION_SHARE: f64 = 0.25;
/// Share of the scatter of a level below which an error of the level is hidden [-]: a tenth.
pub const HIDDEN_SHARE: f64 = 0.1;

/// Level error from which a result carries a warning [dB].
pub const WARNED_ERROR_DB: f64 = 1.0;
/// Error of a load, speed, slip or orbit from which a result carries a warning [-].
pub const WARNED_ERROR_SHARE: f64 = 0.1;
/// Largest error of pocket load, slip and cage orbit, independent of the allowed level error [-]; *limits*. Steps that leave levels unchanged move
/// these numbers by a few per cent.
pub const DETAIL_SHARE: f64 = 0.03;
/// Share of `model_tolerance_db` that a stated error may take [-]: true errors are up to 1.43 times the stated ones
/// (`benches/compare/compare.py`).
pub const STATED_SHARE: f64 = 0.7;
/// Share of `model_tolerance_db` allowed for a model that is verified by a reduced model, which uses the rest [-].
pub const LEAN_SHARE: f64 = 0.7;

/// Change of a level under refinement from which both levels may be noise of the steps [dB]; *steps*.
pub const UNRESOLVED_DB: f64 = 0.5;
/// Rms of the difference of two signals over the signal, from which each signal is an independent sample [-]; *steps*.
pub const INDEPENDENT_NOISE: f64 = 0.3;
/// Ratio of a change under refinement to the last change, above which the change is not noise of the steps [-], and its largest size [dB]; *steps*.
pub const STALLED_SHARE: f64 = 0.5;
pub const STALLED_DB: f64 = 10.0;
/// Growth of a disturbance over the recorded time from which a chaotic motion is a sample of its statistics [e-folds]; *drawn*.
pub const SAMPLE_EFOLDS: f64 = 10.0;
/// Standard errors by which two samples of a chaotic motion may differ [-].
pub const SAMPLE_SIGMAS: f64 = 3.0;
/// Growth of a disturbance in one step up to which it is chaos, not instability of the step [e-folds]; *steps*.
pub const MAX_GROWTH_PER_STEP: f64 = 0.05;

/// Change of the cage speed after a window of verification [-], and drift of the balls in their pockets over their spacing [-], that the window
/// does not cover; *drawn*. Levels deviated by decibels at 20 % and 3 %, and by 0.05 dB at 1.5 %.
pub const CAGE_SPEED_CHANGE: f64 = 5e-3;
pub const BALL_DRIFT: f64 = 1e-2;
/// Rms of the spindle's inertia force over its static load from which the spindle may leave its balls [-]; *limits*.
pub const INERTIA_OVER_PRELOAD: f64 = 0.1;
/// Decay over a window of verification that shows how the spindle comes to rest [e-folds]; *limits*.
pub const MIN_DECAY_EFOLDS: f64 = 2.0;
/// Scatter of a level from which no window represents the rest [dB]; *drawn*.
pub const WINDOW_SCATTER_DB: f64 = 1.5;
/// Sine of a contact angle from which balls are out of the plane [-], and the shortest window that then shows their effect [s]. Share of the
/// approach under load that they take, and growth of the sine [1/s], from which it does not represent the run; *tilt*.
pub const IN_PLANE_SINE: f64 = 5e-4;
pub const OUT_OF_PLANE_SHARE: f64 = 1e-3;
pub const TILT_WINDOW_S: f64 = 0.1;
pub const LEAVING_PLANE_PER_S: f64 = 5.0;

/// Viscosity over shaft speed from which cage and balls may tilt [Pa s²], and from which they may do so late in a run; *drawn*.
pub const TILT_VISCOSITY: f64 = 2.5e-5;
pub const LATE_TILT_VISCOSITY: f64 = 3.5e-5;
/// Mass of a crown cage over that of its balls, and its offset over the ball diameter, that leave levels unchanged [-]; *drawn crowns*.
pub const CROWN_MASS: f64 = 1.0;
pub const CROWN_OFFSET: f64 = 0.5;
/// Largest share of a run that its verification window may be [-]; a shorter run takes the richer model at once.
pub const WINDOW_SHARE: f64 = 0.3;
