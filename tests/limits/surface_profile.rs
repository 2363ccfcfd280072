//! A surface profile is a height added to the penetration.

use raceway::physics::raceway::{RacewayContact, RelativeMotion};
use raceway::physics::surface::SurfaceProfile;

use crate::scenes::{Random, everything, model};

fn contacts() -> [RacewayContact; 2] {
    let raceway = model(&everything()).mechanism().raceway.clone();
    [raceway.inner, raceway.outer]
}

/// A ball near its raceway with velocity, spin and slip.
fn motion(contact: &RacewayContact, outer: bool, random: &mut Random, penetration: f64) -> RelativeMotion {
    let towards = if outer { 1.0 } else { -1.0 };
    // Position of first contact: groove centre circle and approach, from the penetration of a ball on the axis.
    let (at_zero, _) = contact.penetration::<true>(0.0, 0.0);
    let groove = -towards * (at_zero + contact.touch_distance());
    RelativeMotion {
        axial: 2e-6 * random.next(),
        radius: groove + towards * (contact.touch_distance() + penetration),
        velocity: [0.1 * random.next(), 0.1 * random.next(), 13.0 + random.next()],
        spin: [-9600.0 + 500.0 * random.next(), 300.0 * random.next(), 300.0 * random.next()],
        raceway_speed: if outer { 0.0 } else { 5236.0 },
        orbit_speed: 2058.0,
        azimuth: random.next(),
    }
}

/// A height of 0 everywhere changes no bit of any load.
#[test]
fn constant_height_zero_is_no_profile() {
    let mut random = Random::new(5);
    for (side, ideal) in contacts().into_iter().enumerate() {
        let flat = ideal.clone().with_surface(SurfaceProfile::Constant(0.0));
        for _ in 0..200 {
            let motion = motion(&ideal, side == 1, &mut random, 2e-6 + 3e-6 * 0.7);
            let (a, b) = (ideal.load::<false>(&motion), flat.load::<false>(&motion));
            assert!(a.normal > 0.0);
            assert_eq!(format!("{a:?}"), format!("{b:?}"));
            let (a, b) = (ideal.load::<true>(&motion), flat.load::<true>(&motion));
            assert_eq!(format!("{a:?}"), format!("{b:?}"));
        }
    }
}

/// A height h adds h to the penetration, and the load is that of a ball displaced by h. To rounding of the radius.
#[test]
fn constant_height_adds_to_the_penetration() {
    const HEIGHT: f64 = 1.5e-6;
    for (side, ideal) in contacts().into_iter().enumerate() {
        let raised = ideal.clone().with_surface(SurfaceProfile::Constant(HEIGHT));
        for penetration in [-1e-6, 0.5e-6, 4e-6] {
            let at = |penetration| RelativeMotion {
                axial: 0.0,
                velocity: [0.0; 3],
                spin: [0.0; 3],
                raceway_speed: 0.0,
                orbit_speed: 0.0,
                ..motion(&ideal, side == 1, &mut Random::new(7), penetration)
            };
            let (found, expected) =
                (raised.load::<false>(&at(penetration)), ideal.load::<false>(&at(penetration + HEIGHT)));
            assert!((found.penetration - penetration - HEIGHT).abs() < 1e-17);
            assert!(found.normal > 0.0 && (found.normal / expected.normal - 1.0).abs() < 1e-9);
            // The recess opens the contact.
            let recessed = ideal.clone().with_surface(SurfaceProfile::Constant(-HEIGHT));
            let found = recessed.load::<false>(&at(penetration));
            assert_eq!(found.normal > 0.0, penetration > HEIGHT);
        }
    }
}
