//! Reasons to doubt a number, and remarks.

use serde_json::{Value, json};

use super::answer::{MessageAnswer, MessageCode, Severity, message};
use super::candidates::{cause_text, gap_text};
use super::words::{field, listed, numbers, signed, time};
use crate::contract::answer::resonance::envelope_band;
use crate::contract::json::numbers::significant;
use crate::contract::json::units::{DEG, NM};
use raceway_core::physics::surface::waviness::{HIGHEST_FREQUENCY, Omission};
use raceway_core::simulation::error::codes::{SurfacePart, Uncertainty, Warning};
use raceway_core::simulation::error::comparison::SILENCE;
use raceway_core::simulation::input::channel::Channel;
use raceway_core::simulation::result::metrics::level_db;

/// Time constants above this are not worth waiting for [s].
const LONG_WAIT_S: f64 = 60.0;

/// Longest time constant that is shown as a number [s].
const LONGEST_SHOWN_S: f64 = 1000.0;

/// The message of a warning.
pub fn of_warning(warning: &Warning) -> MessageAnswer {
    let (code, text, values): (MessageCode, String, Vec<(&str, Value)>) = match warning {
        Warning::Uncertain { cause, errors } => {
            let (reason, remedy) = match cause {
                Uncertainty::Steps => {
                    ("refinement still changes them", "Select a tighter relative_tolerance, or increase duration_s.")
                }
                Uncertainty::Sensitive => ("the least disturbance leads to other peaks", "Increase duration_s."),
                Uncertainty::ShortSample => {
                    ("the motion is chaotic and the recorded time is a short sample of it", "Increase duration_s.")
                }
                Uncertainty::Uneven => ("levels vary along the recorded time", "Increase duration_s, or settle_s."),
            };
            let text = format!("Large errors of {}: {reason}. {remedy}", listed(errors));
            let stated = errors.iter().map(|error| (field(error.quantity), json!(significant(error.error, 3))));
            let channel = errors.iter().find_map(|error| error.channel);
            let values = stated.chain(channel.map(|channel| ("channel", json!(channel.to_string()))));
            (MessageCode::Uncertain, text, values.collect())
        }
        Warning::NotResolved { change_db, is_selected } => {
            let remedy = match is_selected {
                true => "Leave method, step and tolerance to the program, or tighten them.",
                false => "Select `solver.method` and a tighter `relative_tolerance`, or increase duration_s.",
            };
            let text = format!(
                "A level is not resolved: refinement still changes it by {change_db:.1} dB, so that it has no error and its spectrum no \
                 lines. {remedy}"
            );
            (MessageCode::NotResolved, text, numbers(&[("change_db", *change_db)]))
        }
        Warning::NotStationary { channel, change_db } => {
            let text = format!(
                "Level not stationary: {channel} changed by {change_db:+.1} dB during the recorded time. Increase settle_s, or \
                 duration_s if the level oscillates."
            );
            let values =
                vec![("channel", json!(channel.to_string())), ("change_db", json!(significant(*change_db, 3)))];
            (MessageCode::NotStationary, text, values)
        }
        Warning::StationarityNotChecked { channels } => {
            let level = |(channel, rms): &(Channel, f64)| {
                let noise = if *rms <= SILENCE { ", numerical noise" } else { "" };
                format!("{channel} ({} dB{noise})", signed(level_db(*rms).unwrap_or(f64::NEG_INFINITY)))
            };
            let levels: Vec<String> = channels.iter().map(level).collect();
            let names: Vec<String> = channels.iter().map(|(channel, _)| channel.to_string()).collect();
            let text = format!(
                "Levels below −20 dB were not checked for changes along the recorded time: {}.",
                levels.join(", ")
            );
            (MessageCode::StationarityNotChecked, text, vec![("channels", json!(names))])
        }
        Warning::ShortChaoticSample { growth_time, required } => {
            let text = format!(
                "The motion is chaotic, and disturbances grow by a factor of e in {growth_time:.3} s: the recorded time is too short to be a \
                 sample of it. Set duration_s to {required:.2} or more."
            );
            let values = [("growth_time_s", *growth_time), ("required_duration_s", *required)];
            (MessageCode::ShortChaoticSample, text, numbers(&values))
        }
        Warning::RecordTooShort { recorded, required } => {
            let text = format!(
                "{} are too short for an error estimate. Set duration_s to {} or more.",
                time(*recorded),
                significant(*required, 2)
            );
            (MessageCode::RecordTooShort, text, numbers(&[("required_duration_s", *required)]))
        }
        Warning::NotVerified(failure) => (
            MessageCode::NotVerified,
            format!("No error is known, because the verification failed: {failure}."),
            vec![],
        ),
        Warning::PartlyVerified { window, cause } => {
            let text = format!(
                "The errors were verified over the first {} only, because the repetition of the whole run failed: {cause}.",
                time(*window)
            );
            (MessageCode::PartlyVerified, text, numbers(&[("window_s", *window)]))
        }
        Warning::LaterWindowFailed(failure) => {
            let text = format!(
                "The scatter of the levels is that of the recorded time alone: a later window failed, {failure}."
            );
            (MessageCode::LaterWindowFailed, text, vec![])
        }
        Warning::ModelNotConfirmed { level, allowed_db, cause } => {
            let text = format!(
                "The selected model level {} is not confirmed within {} dB: {}.",
                level.name(),
                significant(*allowed_db, 6),
                cause_text(cause)
            );
            let values = vec![("rung", json!(level.name())), ("allowed_db", json!(significant(*allowed_db, 6)))];
            (MessageCode::ModelNotConfirmed, text, values)
        }
        Warning::ErrorUnknown(gap) => {
            let text =
                format!("No error is stated, because the verification does not cover the run: {}.", gap_text(gap));
            (MessageCode::ErrorUnknown, text, vec![])
        }
        Warning::UnstableStep(unstable) => {
            let largest = unstable.largest_stable();
            let text = format!(
                "Levels can be wrong although the motion stays bounded: {unstable}. Set fixed_step_us to {} or less.",
                significant(1e6 * largest, 2)
            );
            let values = [("step_s", unstable.step), ("largest_stable_step_s", largest)];
            (MessageCode::UnstableStep, text, numbers(&values))
        }
        Warning::StartTransient { time_constant, settle, required, constant_speed } => {
            let remedy = if *required > LONG_WAIT_S {
                "A larger load or more damping shortens it.".to_owned()
            } else if *constant_speed {
                format!("Set settle_s to {required:.2}.")
            } else {
                format!("Hold the first speed for {required:.2} s before anything is recorded.")
            };
            let text = format!(
                "The recorded time may contain the initial transient: free vibration of the spindle decays with a time constant of {} s, and \
                 settle_s is {settle:?}. {remedy}",
                if *time_constant > LONGEST_SHOWN_S {
                    format!("more than {LONGEST_SHOWN_S}")
                } else {
                    significant(*time_constant, 3).to_string()
                }
            );
            let values = [("time_constant_s", *time_constant), ("required_settle_s", *required)];
            (MessageCode::StartTransient, text, numbers(&values))
        }
        Warning::CageTransient { settle, required } => {
            let text = format!(
                "The recorded time may contain vibration of the cage along its axis, which is hardly damped: settle_s is {settle:?}. Set \
                 settle_s to {required} or more."
            );
            (MessageCode::CageTransient, text, numbers(&[("required_settle_s", *required)]))
        }
        Warning::TiltTransient { settle, required } => {
            let text = format!(
                "Cage and balls may still begin to tilt, which takes seconds in so viscous an oil: settle_s is {settle:?}. Set settle_s to \
                 {required}."
            );
            (MessageCode::TiltTransient, text, numbers(&[("required_settle_s", *required)]))
        }
        Warning::MissedResonance { resonance, band: (low, high), advised: (from, to) } => {
            let (low, high) = (significant(*low, 3), significant(*high, 3));
            let text = format!(
                "The envelope of {low} to {high} Hz leaves out the resonance of the spindle on its contacts, {} Hz, which a defect excites most: its \
                 envelope lines are weak. Set outputs.envelope_band_hz to {}.",
                significant(*resonance, 3),
                band_text((*from, *to))
            );
            (MessageCode::MissedResonance, text, numbers(&[("resonance_hz", *resonance)]))
        }
        Warning::UnloadedDefect { azimuth, others } => {
            let azimuth = significant(DEG.to_user(*azimuth), 4);
            let also = match others {
                0 => String::new(),
                1 => ", like another one".to_owned(),
                _ => format!(", like {others} others"),
            };
            let text = format!(
                "The defect of the outer raceway at {azimuth}° lies outside the load zone{also}: no ball is pressed into it, and it changes almost \
                 nothing. Move it to the direction of the load; azimuths count from +Y to +Z."
            );
            (MessageCode::UnloadedDefect, text, numbers(&[("azimuth_deg", azimuth)]))
        }
        Warning::BridgedTroughs { part, order, amplitude, largest } => {
            let text = format!(
                "Waves of {} are too steep: at order {order} the amplitude is {} nm, and a ball follows at most {} nm into the troughs. Reduce \
                 amplitudes or orders.",
                part_text(*part),
                significant(NM.to_user(*amplitude), 3),
                significant(NM.to_user(*largest), 3)
            );
            let amplitudes = [("amplitude_nm", NM.to_user(*amplitude)), ("largest_amplitude_nm", NM.to_user(*largest))];
            let mut values = numbers(&amplitudes);
            values.push(("order", json!(order)));
            (MessageCode::BridgedTroughs, text, values)
        }
        Warning::RoughContact { part, roughness, film } => {
            let (roughness, film) = (NM.to_user(*roughness), NM.to_user(*film));
            let text = format!(
                "Surfaces touch on {}: the waves shorter than the contact have {} nm rms, and the film is {} nm thin. Contact of roughness is not \
                 modelled. Leave these waves out, or thicken the film by speed or viscosity.",
                part_text(*part),
                significant(roughness, 3),
                significant(film, 3)
            );
            (MessageCode::RoughContact, text, numbers(&[("roughness_nm", roughness), ("film_nm", film)]))
        }
        Warning::WavesLeftOut { part, order, others, reason } => {
            let reason = match reason {
                Omission::Averaged => "the contact, which is wider than the waves, averages them away".to_owned(),
                Omission::Fast => format!("they pass faster than {HIGHEST_FREQUENCY} Hz, the range of the record"),
            };
            let more = if *others > 0 { format!(" and {others} more") } else { String::new() };
            let text = format!(
                "The given wave of order {order} on {}{more} changes nothing: {reason}. `derived.surfaces` lists the orders that are left out.",
                part_text(*part)
            );
            (MessageCode::WavesLeftOut, text, vec![("order", json!(order)), ("count", json!(others + 1))])
        }
        Warning::TrackOffEquator { ball, latitude, order } => {
            let degrees = DEG.to_user(*latitude);
            let text = format!(
                "Ball {ball} rolls {}° beside its equator, where its waves fade: orders above {order} are more than 1 dB weaker than given. Give \
                 lower orders, or reduce tilt and axial load.",
                significant(degrees, 2)
            );
            let mut values = numbers(&[("latitude_deg", degrees)]);
            values.extend([("ball", json!(ball)), ("order", json!(order))]);
            (MessageCode::TrackOffEquator, text, values)
        }
        Warning::MergedCageLines { cage, window, required, longest } => {
            let remedy = if required <= longest {
                format!("Set duration_s to {} or more.", significant(*required, 2))
            } else {
                format!("No spectrum is longer than {} s: increase the speed.", significant(*longest, 3))
            };
            let text = format!(
                "Spectra over {} s do not separate lines that differ by the speed of the cage, {} Hz. {remedy}",
                significant(*window, 3),
                significant(*cage, 3)
            );
            let values = [("window_s", *window), ("cage_speed_hz", *cage), ("required_window_s", *required)];
            (MessageCode::MergedCageLines, text, numbers(&values))
        }
    };
    let severity = if warning.is_remark() { Severity::Info } else { Severity::Warning };
    message(code, severity, text, values)
}

/// A band in the form of the request.
fn band_text((low, high): (f64, f64)) -> String {
    let [low, high] = envelope_band(low, high);
    format!("[{low}, {high}]")
}

fn part_text(part: SurfacePart) -> String {
    match part {
        SurfacePart::Inner => "the inner raceway".to_owned(),
        SurfacePart::Outer => "the outer raceway".to_owned(),
        SurfacePart::Ball(number) => format!("ball {number}"),
    }
}
