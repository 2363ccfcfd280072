//! Elastic contact, impact, traction and film of one contact.

use std::f64::consts::PI;

use raceway::numerics::elliptic::complete_elliptic;
use raceway::numerics::roots::bracketed_root;
use raceway::physics::bearing::{Bearing, PerRaceway};
use raceway::physics::contact::damping::{DampingFactor, DampingLaw, impact_damping, normal_load};
use raceway::physics::contact::film::{FilmConditions, minimum_film_thickness};
use raceway::physics::contact::hertz::{ContactEllipse, load_deflection_factor, max_pressure, semi_axes};
use raceway::physics::contact::traction::TractionLaw;
use raceway::physics::lubricant::{Lubricant, LubricantKind};
use raceway::physics::raceway::{RacewayContact, RacewayTerms, RelativeMotion};
use serde_json::json;

use crate::distribution::scene;
use crate::table::check;

/// Dimensionless a*, b*, δ* of a curvature difference F(ρ), with a = a* (3Q/(2Σρ E'))^⅓ and so on.
#[test]
fn ellipse() {
    for (case, difference) in [
        ("hertz-0.1075", 0.1075),
        ("hertz-0.4795", 0.4795),
        ("hertz-0.7948", 0.7948),
        ("hertz-0.90999", 0.909_99),
        ("hertz-0.95738", 0.957_38),
        ("hertz-0.990902", 0.990_902),
        ("hertz-0.9989156", 0.998_915_6),
    ] {
        let ellipse = ContactEllipse::new(1.0 + difference, 1.0 - difference);
        let (k, first, second) = (ellipse.ellipticity, ellipse.elliptic_first, ellipse.elliptic_second);
        let a = (2.0 * k * k * second / PI).cbrt();
        let b = (2.0 * second / (PI * k)).cbrt();
        check(case, &[a, b, 2.0 * first / PI * (PI / (2.0 * k * k * second)).cbrt()]);
    }
}

#[test]
fn sphere_on_flat() {
    let (radius, modulus, load) = (10e-3, 115.385e9, 50.0);
    let ellipse = ContactEllipse::new(1.0 / radius, 1.0 / radius);
    let stiffness = load_deflection_factor(&ellipse, 2.0 * modulus);
    let (a, b) = semi_axes(&ellipse, 2.0 * modulus, load);
    assert_eq!(a, b);
    let deflection = (load / stiffness).powf(2.0 / 3.0);
    check("sphere-on-flat", &[a * 1e6, max_pressure(&ellipse, 2.0 * modulus, load) * 1e-6, deflection * 1e6]);
}

/// An undamped impact at 0.1 m/s with the normal load of the program, in leapfrog steps of 1/20 000 of its duration.
#[test]
fn impact_time() {
    let (mass, stiffness, speed) = (8.789e-5_f64, 1.399e10_f64, 0.1_f64);
    let unit = (5.0 * mass / (4.0 * stiffness)).powf(0.4) * speed.powf(-0.2);
    let step = 2.9432 * unit / 20_000.0;
    let acceleration = |depth: f64| -normal_load(stiffness, depth, 0.0, &DampingFactor::default()) / mass;
    let (mut depth, mut last, mut rate, mut time) = (0.0_f64, 0.0, speed, 0.0);
    while depth >= 0.0 {
        last = depth;
        rate += 0.5 * step * acceleration(depth);
        depth += step * rate;
        rate += 0.5 * step * acceleration(depth);
        time += step;
    }
    time -= step * depth / (depth - last);
    check("impact-time", &[time / unit]);
}

#[test]
fn restitution() {
    for (case, restitution) in [("restitution-0.9", 0.9), ("restitution-0.6", 0.6), ("restitution-0.5", 0.5)] {
        check(case, &[impact_damping(restitution)]);
    }
}

#[test]
fn published_damping() {
    let (restitution, at_speed) = (0.9, 0.1);
    for (case, law) in [
        ("hunt-crossley", DampingLaw::HuntCrossley { restitution, at_speed }),
        ("lankarani-nikravesh", DampingLaw::LankaraniNikravesh { restitution, at_speed }),
        ("flores", DampingLaw::Flores { restitution, at_speed }),
    ] {
        check(case, &[law.resolve().chi]);
    }
}

/// The outer raceway of the article's bearing with friction that saturates at a very low slip speed.
fn rubbing(strips: usize, conformity: bool) -> (Bearing, RacewayContact) {
    let bearing = scene(&json!({ "bearing": "article-integrated" })).bearing;
    let lubricant = Lubricant {
        kind: LubricantKind::Dry,
        viscosity: 0.0,
        pressure_viscosity: 0.0,
        fill: 0.0,
        inlet_distance: None,
        traction: TractionLaw::Coulomb { coefficient: FRICTION, regularisation: 1e-6 },
    };
    let terms = RacewayTerms { strips, gauss: false, conformity, spin: true, hydrodynamics: false };
    let PerRaceway { outer, .. } = RacewayContact::pair(&bearing, &lubricant, DampingFactor::default(), terms);
    (bearing, outer)
}

const FRICTION: f64 = 0.08;

/// A ball pressed outwards by 5 µm.
fn pressed(bearing: &Bearing, contact: &RacewayContact) -> RelativeMotion {
    let touching = bearing.groove_centre_radius.outer + contact.touch_distance();
    RelativeMotion { radius: touching + 5e-6, ..RelativeMotion::default() }
}

/// Moment about the contact normal of a ball in pure spin, over μQa.
#[test]
fn pure_spin() {
    let (bearing, contact) = rubbing(17, false);
    let load = contact.load::<false>(&RelativeMotion { spin: [0.0, 1000.0, 0.0], ..pressed(&bearing, &contact) });
    let a = contact.hertz().semi_axes(load.normal).0;
    let moment = load.moment[1].abs() / (FRICTION * load.normal * a);
    let ellipse = &contact.hertz().ellipse;
    let second = complete_elliptic(ellipse.ellipticity.powi(-2)).second;
    crate::table::check_computed("pure-spin", &[0.375 * second], &[moment]);
    let (bearing, contact) = rubbing(32, false);
    let load = contact.load::<false>(&RelativeMotion { spin: [0.0, 1000.0, 0.0], ..pressed(&bearing, &contact) });
    let a = contact.hertz().semi_axes(load.normal).0;
    check("pure-spin-strips", &[load.moment[1].abs() / (FRICTION * load.normal * a)]);
}

/// Lines without slip of a ball that rolls freely on a conforming groove.
///
/// Where the sum of the traction vanishes, they are the lines at which the speed of its deformed surface, ω h(η), equals that
/// of the groove.
#[test]
fn no_slip_lines() {
    let (bearing, contact) = rubbing(33, true);
    let still = pressed(&bearing, &contact);
    let spin = 1000.0;
    let traction = |speed: f64| {
        let motion = RelativeMotion { velocity: [0.0, 0.0, speed], spin: [-spin, 0.0, 0.0], ..still };
        contact.load::<true>(&motion).force[2]
    };
    let radius = 0.5 * bearing.parameters.ball_diameter;
    let a = contact.hertz().semi_axes(contact.load::<true>(&still).normal).0;
    let deformed = contact.hertz().deformed_radius;
    let height = |place: f64| {
        (deformed * deformed - place * place).sqrt() - (deformed * deformed - a * a).sqrt()
            + (radius * radius - a * a).sqrt()
    };
    let rolling = bracketed_root(traction, spin * height(a), spin * height(0.0));
    let line = bracketed_root(|share| spin * height(share * a) - rolling, 0.0, 1.0);
    check("no-slip-lines", &[line]);
}

#[test]
fn film_of_the_209() {
    let conditions = FilmConditions {
        viscosity: 0.04,
        pressure_viscosity: 2.3e-8,
        effective_modulus: 228e9,
        rolling_radius: 5.109e-3,
        ellipticity: ContactEllipse::new(1.0 / 5.109e-3, 1.0 / 167.6e-3).ellipticity,
        rolling_speed: 6.252,
        load: 5.0 * 8900.0 / 9.0,
    };
    check("film-209", &[minimum_film_thickness(&conditions) * 1e6]);
}
