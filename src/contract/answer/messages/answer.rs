//! A message: code, severity, text and values.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

/// A remark or a warning about a result or a scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct MessageAnswer {
    /// Kind of the message. Programs branch on it.
    pub code: MessageCode,
    /// How much it matters.
    pub severity: Severity,
    /// One or two plain sentences: what happened, the numbers, and what to do.
    pub text: String,
    /// The numbers and names of the text, by name with unit.
    #[serde(flatten)]
    #[schema(additional_properties, value_type = BTreeMap<String, Value>)]
    pub values: BTreeMap<String, Value>,
}

/// `info`: how the result was made. `warning`: a reason to doubt a number or the whole result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Severity {
    Info,
    Warning,
}

/// Code of a message; programs branch on it.
///
/// `uncertain`: Errors of numbers are large. Increase the time or tighten the tolerance that the text names.
///
/// `not-resolved`: Refinement still changes a level by more than 1 dB. The level has no error, is marked `resolved: false`, and is never the best of
/// a study. The text names what may resolve it.
///
/// `not-stationary`: A level rises or falls throughout the recorded time. Increase `settle_s`, or `duration_s` if the level oscillates.
///
/// `stationarity-not-checked`: A level below −20 dB, or below numerical noise, was not checked for changes along the recorded time.
///
/// `short-chaotic-sample`: A chaotic motion was recorded for too short a time. Increase `duration_s`.
///
/// `record-too-short`: The recorded time is too short for an error estimate. Increase `duration_s`.
///
/// `not-verified`: The verification failed, so that no error is known. The text names the failure.
///
/// `partly-verified`: The verification covers the first part of the recorded time alone.
///
/// `later-window-failed`: A later window could not be recorded: the scatter of the levels is that of the recorded time alone.
///
/// `model-not-confirmed`: The selected model level deviates by more than is allowed. Select a richer level, or none.
///
/// `error-unknown`: The window of verification does not cover the run. Leave `solver.rung` out, or select `full`.
///
/// `unstable-step`: The fixed step is unstable and the result is wrong. Shorten `solver.fixed_step_us`.
///
/// `start-transient`: The recorded time may contain free vibration of the start. Increase `settle_s`.
///
/// `cage-transient`: The recorded time may contain vibration of the cage along its axis. Increase `settle_s`.
///
/// `tilt-transient`: Cage and balls may still begin to tilt in viscous oil. Increase `settle_s`.
///
/// `missed-resonance`: The band of the envelope leaves out the resonance that a defect excites most. Set `outputs.envelope_band_hz` to the band that the
/// text names.
///
/// `unloaded-defect`: A defect of the outer raceway lies where no ball is pressed into it, and changes almost nothing. Move it into the load zone.
///
/// `bridged-troughs`: A ball cannot follow the troughs of waves, which the model supposes. Reduce their amplitude or order.
///
/// `rough-contact`: The heights within a contact exceed its film, so that the surfaces touch, which is not modelled. Leave short waves out.
///
/// `waves-left-out`: A given wave changes nothing: the contact averages it away, or it passes faster than the record shows. Leave it out.
///
/// `track-off-equator`: A ball rolls beside its equator, where its waves fade. Give lower orders, or reduce tilt and axial load.
///
/// `merged-cage-lines`: Spectra do not separate lines that differ by the cage speed. Increase `duration_s`, or the speed.
///
/// `overloaded`: A pressure of a bearing on a shaft deforms its raceway permanently, which the elastic model does not show. Reduce the load.
///
/// `open-side`: An angular-contact bearing on a shaft carries thrust over its open side, where real rings come apart. Turn it round, or raise the
/// preload.
///
/// `unnamed-line`: No order, ball passage or load makes the strongest line of a machine, which may whirl by itself. Widen the pockets of its cages.
///
/// `velocity-not-resolved`: The record is too short for the velocity from 10 to 1000 Hz. Set `duration_s` to 0.2 or more.
///
/// `power-beyond-bands`: The power of the bands is not that of the signal. Increase `duration_s`; where the speed changes, keep `outputs.orders`.
///
/// `line-at-edge`: A line lies at the edge of two bands, so that both have a share of it. Increase `duration_s`, or move the edge.
///
/// `friction-adds-forces`: In grease the friction moment needs hydrodynamic forces, which a run without it leaves out. Its vibration differs.
///
/// `failed-samples`: More than 5 % of the sampled points have no value of the metric. Percentiles may leave out the worst of them.
///
/// `spread-not-resolved`: The integration error exceeds half of the spread. Tighten the tolerance or increase `duration_s`.
///
/// `ranking-not-resolved`: One-by-one effects of the inputs explain less than half of the variance. Use `pairs`, which also gives interactions.
///
/// `candidate-rejected`: A model level or step was tried and rejected. Another one made the result.
///
/// `model-not-eligible`: A model level was not tried. The text names the reason.
///
/// `method-chosen`: The reason why `auto` runs this integrator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MessageCode {
    Uncertain,
    NotResolved,
    NotStationary,
    StationarityNotChecked,
    ShortChaoticSample,
    RecordTooShort,
    NotVerified,
    PartlyVerified,
    LaterWindowFailed,
    ModelNotConfirmed,
    ErrorUnknown,
    UnstableStep,
    StartTransient,
    CageTransient,
    TiltTransient,
    MissedResonance,
    UnloadedDefect,
    BridgedTroughs,
    RoughContact,
    WavesLeftOut,
    TrackOffEquator,
    MergedCageLines,
    Overloaded,
    OpenSide,
    UnnamedLine,
    VelocityNotResolved,
    PowerBeyondBands,
    LineAtEdge,
    FrictionAddsForces,
    FailedSamples,
    SpreadNotResolved,
    RankingNotResolved,
    CandidateRejected,
    ModelNotEligible,
    MethodChosen,
}

pub fn message<'a>(
    code: MessageCode,
    severity: Severity,
    text: String,
    values: impl IntoIterator<Item = (&'a str, Value)>,
) -> MessageAnswer {
    let values = values.into_iter().map(|(name, value)| (name.to_owned(), value)).collect();
    MessageAnswer { code, severity, text, values }
}
