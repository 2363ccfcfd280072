//! Rating life, viscosity ratio and empirical friction moments.

use raceway::contract::scene_from_json;
use raceway::physics::bearing::PerRaceway;
use raceway::physics::friction_reference::{Running, Supply};
use raceway::physics::life::basic::{basic_life, equivalent_load, hours};
use raceway::physics::life::lubrication::reference_viscosity;
use raceway::physics::life::ratings::Ratings;
use raceway::physics::life::reference::{LoadMeans, contact_ratings, reference_life};
use raceway::simulation::model::equilibrium::static_loads;
use serde_json::json;

use crate::distribution::needs;
use crate::table::check;

/// One revolution per minute [rad/s].
const RPM: f64 = std::f64::consts::TAU / 60.0;
const INNER_TURNS: PerRaceway<bool> = PerRaceway { inner: true, outer: false };

#[test]
fn basic() {
    let of_6205 = Ratings { dynamic: 14e3, statical: 7850.0, static_factor: 13.9 };
    let of = equivalent_load(&of_6205, 0.0, 500.0, 200.0);
    let life = hours(basic_life(of_6205.dynamic, of.load), 3000.0 * RPM);
    check("life-6205", &[of.factors.limit, of.factors.axial, of.load, life]);
    check("life-6309", &[hours(basic_life(55.3e3, 4e3), 1800.0 * RPM)]);
}

#[test]
fn viscosity() {
    let reference = reference_viscosity(72.5e-3, 1800.0 * RPM);
    check("kappa-6309", &[reference, 21.6 / reference]);
}

/// Displacements [µm] and reference lives [10⁶ turns].
#[test]
fn reference() {
    for (case, clearance_um, axial, radial, tilt) in [
        ("life-masta-radial", 0.0, 0.0, 1e3, "held"),
        ("life-masta-clearance", 10.0, 0.0, 1e3, "held"),
        ("life-masta-axial", 10.0, 1e3, 0.0, "held"),
        ("life-masta-combined", 10.0, 1e3, 1e3, "free"),
    ] {
        let steel = json!({ "elastic_modulus_gpa": 210, "poisson_ratio": 0.3, "density_kg_m3": 7830 });
        let scene = json!({
            "bearing": {
                "outer_diameter_mm": 72, "inner_diameter_mm": 20, "width_mm": 19, "ball_count": 7, "ball_diameter_mm": 11.5,
                "pitch_diameter_mm": 43.5, "inner_groove_curvature": 0.52, "outer_groove_curvature": 0.53,
                "radial_clearance_um": clearance_um,
                "materials": { "ball": steel, "inner_raceway": steel, "outer_raceway": steel }
            },
            "spindle": { "tilt": tilt }, "gravity_m_s2": 0,
            "operation": { "speed_rpm": 1000, "radial_load_y_n": radial, "axial_load_n": axial }
        });
        let scene = scene_from_json(&scene.to_string()).unwrap_or_else(|refusal| panic!("{refusal:?}"));
        let at_rest = static_loads(&scene, &needs(&scene)).unwrap();
        let mut means = LoadMeans::new(INNER_TURNS);
        at_rest.raceway_loads.iter().for_each(|load| means.add(*load));
        let life = reference_life(contact_ratings(&scene.bearing, 23_400.0), means.means());
        let moved = if axial == 0.0 { at_rest.radial_displacement } else { at_rest.axial_displacement };
        check(case, &[1e6 * moved, life]);
    }
    let mut means = LoadMeans::new(INNER_TURNS);
    for load in [1e3, 2e3] {
        means.add(PerRaceway { inner: load, outer: load });
    }
    let PerRaceway { inner, outer } = means.means();
    check("power-means", &[1e-3 * inner, 1e-3 * outer]);
}

/// 6205 at 3000 r/min in 20 mm²/s.
#[test]
fn moments() {
    for (case, radial, axial) in [("skf-500", 500.0, 0.0), ("skf-1000", 1000.0, 0.0), ("skf-combined", 500.0, 200.0)] {
        let running =
            Running { bore: 25.0, outside: 52.0, static_rating: 7800.0, radial, axial, speed: 3000.0, viscosity: 20.0 };
        let of = running.skf("62", Supply::OilBath).unwrap();
        check(case, &[of.rolling, of.sliding]);
        if case == "skf-500" {
            let palmgren = Running { static_rating: 7850.0, ..running }.palmgren();
            check("palmgren-500", &[palmgren.viscous, palmgren.of_load[0], palmgren.of_load[1]]);
        }
    }
}
