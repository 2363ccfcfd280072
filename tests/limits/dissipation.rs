//! Friction dissipates energy: the power that a contact takes from both bodies is not negative in any motion. This fails
//! where force, moment and slip are inconsistent.

use raceway::physics::frames::{dot, scale, subtract};
use raceway::physics::pocket::PocketMotion;
use raceway::physics::raceway::RelativeMotion;
use serde_json::{Value, json};

use crate::scenes::{Random, article, changed, everything, model};

/// Raceways without damping: the power of force and moment on ball and raceway without the elastic part −Q δ̇, for each law and
/// term alone. To rounding of the summands.
#[test]
fn raceways_take_energy_from_slip_spin_and_rolling() {
    let undamped = changed(everything(), json!({ "damping": { "raceway": { "law": "none" } } }));
    let with = |traction: Value, terms: Value| {
        changed(undamped.clone(), json!({ "lubricant": { "traction": traction }, "terms": terms }))
    };
    let no_traction = json!({ "maximum": 0, "limit": 0 });
    let dry = json!({ "hydrodynamics": "off" });
    for (name, json) in [
        ("everything", undamped.clone()),
        ("traction", with(json!({}), dry.clone())),
        ("no spin", with(json!({}), json!({ "hydrodynamics": "off", "spin": "off" }))),
        ("no conformity", with(json!({}), json!({ "hydrodynamics": "off", "conformity": "off" }))),
        ("sticking", with(json!({ "at_rest": 0.02 }), dry.clone())),
        ("Eyring", with(json!({ "law": "eyring" }), dry.clone())),
        ("Coulomb", with(json!({ "law": "coulomb" }), dry.clone())),
        ("inlet", with(no_traction, json!({ "hydrodynamics": "on" }))),
    ] {
        let model = model(&json);
        let m = model.mechanism();
        let mut random = Random::new(11);
        for (contact, radius, speed) in [(&m.raceway.inner, 6.5e-3, 5236.0), (&m.raceway.outer, 6.5e-3, 0.0)] {
            for trial in 0..500 {
                // From almost pure rolling to large slip, in both directions.
                let far = [0.0, 1e-3, 0.03, 0.3][trial % 4];
                let sign = if trial % 8 < 4 { 1.0 } else { -1.0 };
                let speed = sign * speed;
                let orbit = sign * m.orbit_ratio * 5236.0;
                let spin = sign * m.spin_ratio * 5236.0;
                let towards = if speed == 0.0 { 1.0 } else { -1.0 };
                let motion = RelativeMotion {
                    axial: 10e-6 * random.next(),
                    radius: radius + towards * 6e-6,
                    velocity: [far * random.next(), far * random.next(), radius * orbit + 3.0 * far * random.next()],
                    spin: [spin + 2e3 * far * random.next(), 2e3 * far * random.next(), 2e3 * far * random.next()],
                    raceway_speed: speed,
                    orbit_speed: orbit,
                    azimuth: 0.0,
                };
                let load = contact.load::<false>(&motion);
                assert!(load.normal > 1.0);
                let (_, (towards_a, towards_r)) = contact.penetration::<false>(motion.axial, motion.radius);
                let rate = towards_a * motion.velocity[0] + towards_r * motion.velocity[1];
                let past = subtract(motion.velocity, [0.0, 0.0, speed * motion.radius]);
                let turning = subtract(motion.spin, [speed, 0.0, 0.0]);
                let parts = [dot(load.force, past), dot(load.moment, turning), load.normal * rate];
                let power: f64 = parts.iter().sum();
                let size: f64 = parts.iter().map(|part| part.abs()).sum();
                assert!(power <= 1e-12 * size, "{name}: {power:e} W of {size:e} W at {motion:?}");
            }
        }
    }
}

/// Rolling friction acts at the contact point along the groove. Its moment on the ball is normal to the contact normal, to
/// rounding, and brakes the rolling of the ball on both raceways.
#[test]
fn rolling_friction_turns_no_ball_about_its_contact_normal() {
    let model = model(&changed(everything(), json!({ "lubricant": { "traction": { "maximum": 0, "limit": 0 } } })));
    let m = model.mechanism();
    let (orbit, spin) = (m.orbit_ratio * 5236.0, m.spin_ratio * 5236.0);
    for (contact, towards, speed) in [(&m.raceway.inner, -1.0, 5236.0), (&m.raceway.outer, 1.0, 0.0)] {
        for axial in [-30e-6, 10e-6, 30e-6] {
            let radius = 6.5e-3 + towards * 10e-6;
            let motion = RelativeMotion {
                axial,
                radius,
                velocity: [0.0, 0.0, radius * orbit],
                spin: [spin, 0.0, 0.0],
                raceway_speed: speed,
                orbit_speed: orbit,
                azimuth: 0.0,
            };
            let load = contact.load::<false>(&motion);
            let (_, (towards_a, towards_r)) = contact.penetration::<false>(axial, radius);
            let about_normal = dot(load.moment, [towards_a, towards_r, 0.0]);
            let size = dot(load.moment, load.moment).sqrt();
            assert!(towards_a.abs() > 0.05 && size > 1e-6);
            assert!(about_normal.abs() < 1e-12 * size, "{about_normal:e} of {size:e} N m");
            assert!(load.moment[0] * (spin - orbit) < 0.0);
        }
    }
}

/// Pockets with an elastic film and solid contact: friction, rolling friction and film shear dissipate energy.
#[test]
fn pockets_take_energy_from_sliding_and_rolling() {
    let elastic = json!({
        "damping": { "pocket": { "law": "none" } },
        "bearing": { "cage": { "film": { "stiffness_n_per_m": 3.8e4, "damping_n_s_per_m": 0 } } }
    });
    let oil = changed(everything(), elastic.clone());
    for (name, json) in [
        ("grease", changed(article(), elastic)),
        ("oil", oil.clone()),
        ("oil without friction", changed(oil, json!({ "terms": { "pocket_friction": "off" } }))),
    ] {
        let model = model(&json);
        let pocket = &model.mechanism().pocket;
        let mut random = Random::new(13);
        let mut vector = |size: f64| [(); 3].map(|()| size * random.next());
        for trial in 0..2000 {
            let far = [1e-3, 0.1, 1.0, 10.0][trial % 4];
            let [x, y, z] = vector(1e3 * far);
            let motion = PocketMotion {
                displacement: vector(35e-6),
                velocity: vector(far),
                spin: [x - 11_700.0, y, z],
                oversize: 0.0,
            };
            let load = pocket.load(&motion);
            if load.normal == 0.0 {
                continue;
            }
            let normal = scale(-1.0 / dot(load.lever, load.lever).sqrt(), load.lever);
            let elastic = load.normal * dot(normal, motion.velocity);
            let parts = [dot(load.force, motion.velocity), dot(load.moment, motion.spin), -elastic];
            let power: f64 = parts.iter().sum();
            let size: f64 = parts.iter().map(|part| part.abs()).sum();
            assert!(power <= 1e-12 * size, "{name}: {power:e} W of {size:e} W at {motion:?}");
        }
    }
}
