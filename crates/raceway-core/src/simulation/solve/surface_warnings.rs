//! Limits of what a run can say about waves and defects, known before it: the envelope's band, defects without load, troughs that a ball
//! bridges, roughness beside the film, and lines that the spectra do not separate.

use crate::physics::bearing::PerRaceway;
use crate::physics::contact::film::{FilmConditions, minimum_film_thickness};
use crate::physics::frames::Vector;
use crate::physics::kinematics::ideal_frequencies;
use crate::physics::raceway::RacewayContact;
use crate::physics::surface::ball::BallSurface;
use crate::physics::surface::waviness::{AveragingContact, KeptWave, Omission, RacewaySurface, SortedWaves, Wave};
use crate::simulation::error::codes::{SurfacePart, Warning};
use crate::simulation::error::thresholds::WARNED_ERROR_DB;
use crate::simulation::input::scene::Scene;
use crate::simulation::input::settings::RunSettings;
use crate::simulation::model::Mechanism;
use crate::simulation::model::contact_resonance::{contact_resonances, excited_along};
use crate::simulation::model::equilibrium::equilibrium;
use crate::simulation::model::surfaces::{
    AveragedBall, AveragedSurface, averaged_balls, averaged_surfaces, ball_loads_at,
};
use crate::simulation::recording::ball_tracks::BallTrack;

/// Width of a line of a Hann spectrum over its resolution [-]: two lines so far apart are separate.
const HANN_LINE_BINS: f64 = 4.0;

/// Warnings of the surfaces of a scene on its ideal mechanism; empty where all are ideal.
pub fn surface_warnings(scene: &Scene, ideal: &Mechanism, settings: &RunSettings) -> Vec<Warning> {
    if averaged_surfaces(ideal, scene).is_none() {
        return Vec::new();
    }
    let mut found = contact_warnings(scene, ideal);
    found.extend(merged_cage_lines(scene, settings));
    found.extend(missed_resonance(scene, ideal, settings));
    found
}

/// Those that follow from the contacts alone, whatever is recorded.
pub(crate) fn contact_warnings(scene: &Scene, ideal: &Mechanism) -> Vec<Warning> {
    let Some(raceways) = averaged_surfaces(ideal, scene) else { return Vec::new() };
    let balls = averaged_balls(ideal, scene);
    let inner = Raceway { part: SurfacePart::Inner, contact: &ideal.raceway.inner, surface: &raceways.inner };
    let outer = Raceway { part: SurfacePart::Outer, contact: &ideal.raceway.outer, surface: &raceways.outer };
    let of_inner: Vec<&AveragedBall> = balls.iter().map(|ball| &ball.inner).collect();
    let of_outer: Vec<&AveragedBall> = balls.iter().map(|ball| &ball.outer).collect();
    let mut found: Vec<Warning> = Vec::new();
    found.extend(bridged_troughs(&inner, &of_inner).or_else(|| bridged_troughs(&outer, &of_outer)));
    found.extend(rough_contact(scene, &inner, &of_inner).or_else(|| rough_contact(scene, &outer, &of_outer)));
    found.extend(waves_left_out(scene, &raceways, &balls));
    found.extend(unloaded_defect(scene, ideal));
    found
}

/// A ball whose contacts run beside its equator, where cos^n of a wave of order n is left, by more than a warned error of the highest wave.
pub(crate) fn track_off_equator(scene: &Scene, ideal: &Mechanism, tracks: &[BallTrack]) -> Option<Warning> {
    let balls = averaged_balls(ideal, scene);
    let of_ball = |(index, (ball, track)): (usize, (&PerRaceway<AveragedBall>, &BallTrack))| {
        let kept = ball.inner.waves.kept.iter().chain(&ball.outer.waves.kept);
        let highest = kept.map(|kept| kept.wave.order).max()?;
        // cos^n λ = 10^(−dB/20); no order fades on the equator.
        let decay = -track.latitude.cos().ln();
        let order = (WARNED_ERROR_DB / 20.0 * std::f64::consts::LN_10) / decay;
        let latitude = track.latitude;
        (decay > 0.0 && f64::from(highest) > order).then(|| Warning::TrackOffEquator {
            ball: index + 1,
            latitude,
            order: order as u32,
        })
    };
    balls.iter().zip(tracks).enumerate().find_map(of_ball)
}

/// A raceway with its contact and the surface as the contact averages it.
struct Raceway<'a> {
    part: SurfacePart,
    contact: &'a RacewayContact,
    surface: &'a AveragedSurface,
}

/// The surface of a raceway or of a ball on it whose troughs are more curved than the ball can follow.
fn bridged_troughs(raceway: &Raceway<'_>, balls: &[&AveragedBall]) -> Option<Warning> {
    let of_ball = |(index, ball): (usize, &&AveragedBall)| {
        too_curved(SurfacePart::Ball(index + 1), raceway.contact, &ball.waves, ball.contact.radius)
    };
    let AveragedSurface { waves, contact, .. } = raceway.surface;
    too_curved(raceway.part, raceway.contact, waves, contact.radius)
        .or_else(|| balls.iter().enumerate().find_map(of_ball))
}

/// Waves on a surface of some radius [m] whose curvature, A n²/R² of a single one, exceeds half of the relative curvature of the contact.
fn too_curved(part: SurfacePart, contact: &RacewayContact, waves: &SortedWaves, radius: f64) -> Option<Warning> {
    let curvature = |amplitude: f64, order: u32| amplitude * (f64::from(order) / radius).powi(2);
    let limit = 0.5 / contact.hertz().rolling_radius;
    let of = |kept: &KeptWave| curvature(kept.wave.amplitude, kept.wave.order);
    let all = waves.kept.iter().map(|kept| of(kept) * of(kept)).sum::<f64>().sqrt();
    let most = waves.kept.iter().max_by(|a, b| of(a).total_cmp(&of(b))).filter(|_| all > limit)?;
    let largest = most.wave.amplitude * limit / all;
    Some(Warning::BridgedTroughs { part, order: most.wave.order, amplitude: most.wave.amplitude, largest })
}

/// The first part of which a given wave is not in the model. Drawn waves may end where they please.
fn waves_left_out(
    scene: &Scene,
    raceways: &PerRaceway<AveragedSurface>,
    balls: &[PerRaceway<AveragedBall>],
) -> Option<Warning> {
    let of = |part: SurfacePart, waves: &[Wave], contacts: &[&AveragingContact]| {
        let given = waves.iter().filter(|wave| wave.amplitude != 0.0);
        let reasons = |wave: &Wave| -> Option<Vec<Omission>> {
            contacts.iter().map(|contact| contact.omission(wave.order)).collect()
        };
        let mut left_out = given.filter_map(|wave| Some((wave.order, *reasons(wave)?.first()?)));
        let (order, reason) = left_out.next()?;
        Some(Warning::WavesLeftOut { part, order, others: left_out.count(), reason })
    };
    let of_raceway = |part: SurfacePart, given: &RacewaySurface, averaged: &AveragedSurface| {
        let contact = [&averaged.contact];
        of(part, &given.waviness, &contact).or_else(|| of(part, &given.axial_waviness, &contact))
    };
    let of_ball = |(index, (given, averaged)): (usize, (&BallSurface, &PerRaceway<AveragedBall>))| {
        let contacts = [&averaged.inner.contact, &averaged.outer.contact];
        of(SurfacePart::Ball(index + 1), &given.waviness, &contacts)
    };
    let given = &scene.surfaces.raceway;
    of_raceway(SurfacePart::Inner, &given.inner, &raceways.inner)
        .or_else(|| of_raceway(SurfacePart::Outer, &given.outer, &raceways.outer))
        .or_else(|| scene.surfaces.balls.iter().zip(balls).enumerate().find_map(of_ball))
}

/// A film that is thinner than the heights within the contact, those that averaging removes.
fn rough_contact(scene: &Scene, raceway: &Raceway<'_>, balls: &[&AveragedBall]) -> Option<Warning> {
    let AveragedSurface { waves, contact, load, .. } = raceway.surface;
    let of_balls = balls.iter().map(|ball| ball.waves.removed_square).fold(0.0, f64::max);
    let roughness = (waves.removed_square + of_balls).sqrt();
    let speed = std::f64::consts::TAU * contact.turns * contact.radius;
    let (viscosity, pressure) = (scene.lubricant.viscosity, scene.lubricant.pressure_viscosity);
    let film = minimum_film_thickness(&FilmConditions::of(raceway.contact.hertz(), viscosity, pressure, speed, *load));
    (viscosity > 0.0 && *load > 0.0 && roughness > film).then_some(Warning::RoughContact {
        part: raceway.part,
        roughness,
        film,
    })
}

/// Spectra that do not separate lines that differ by the speed of the cage.
fn merged_cage_lines(scene: &Scene, settings: &RunSettings) -> Option<Warning> {
    let cage = ideal_frequencies(&scene.bearing, scene.operating_speeds()).cage;
    let longest = settings.outputs.longest_window;
    let window = settings.duration.min(longest);
    let is_short = settings.outputs.have_spectra() && cage > 0.0 && cage * window < HANN_LINE_BINS;
    is_short.then_some(Warning::MergedCageLines { cage, window, required: HANN_LINE_BINS / cage, longest })
}

/// A band of the envelope without the resonance that a defect excites most.
fn missed_resonance(scene: &Scene, ideal: &Mechanism, settings: &RunSettings) -> Option<Warning> {
    let directions = struck_directions(scene, ideal);
    if !settings.outputs.have_spectra() || directions.is_empty() {
        return None;
    }
    let resonances = contact_resonances(ideal, scene.operating_speeds());
    let (low, high) = settings.outputs.envelope.band;
    let mut excited = directions.iter().filter_map(|direction| excited_along(&resonances, *direction));
    let resonance = excited.find(|excited| !(low..=high).contains(&excited.frequency))?;
    Some(Warning::MissedResonance { resonance: resonance.frequency, band: (low, high), advised: resonance.band() })
}

/// Defects of a standing outer raceway that no ball is pressed into, under loads that do not change.
fn unloaded_defect(scene: &Scene, ideal: &Mechanism) -> Option<Warning> {
    if !scene.operation.rotation().outer_stands() || !scene.operation.is_steady() {
        return None;
    }
    let defects = scene.surfaces.raceway.outer.defects.iter().filter(|defect| defect.depth > 0.0);
    let mut unloaded = defects.filter(|defect| ball_loads_at(ideal, scene, defect.azimuth).inner == 0.0);
    let azimuth = unloaded.next()?.azimuth;
    Some(Warning::UnloadedDefect { azimuth, others: unloaded.count() })
}

/// Directions in which defects push the spindle: one of an outer ring that stands in the load zone along its azimuth, others, which turn through the
/// load, along the load.
fn struck_directions(scene: &Scene, ideal: &Mechanism) -> Vec<Vector> {
    let surfaces = &scene.surfaces;
    let stands = scene.operation.rotation().outer_stands();
    let outer = surfaces.raceway.outer.defects.iter().filter(|defect| stands && defect.depth > 0.0);
    let in_zone = outer.filter(|defect| ball_loads_at(ideal, scene, defect.azimuth).inner > 0.0);
    let mut found: Vec<Vector> = in_zone.map(|defect| [0.0, defect.azimuth.cos(), defect.azimuth.sin()]).collect();
    let outer_turns = !stands && surfaces.raceway.outer.has_defects();
    if outer_turns || surfaces.raceway.inner.has_defects() || surfaces.balls_have_defects() {
        found.extend(equilibrium(ideal, scene.operating_speeds()).ok().map(|rest| rest.spindle));
    }
    found
}
