//! Drag and churning of balls, and the film of a guiding land.

use std::f64::consts::{PI, TAU};

use raceway::physics::cage::GuidingLand;
use raceway::physics::contact::traction::TractionLaw;
use raceway::physics::drag::{churning_coefficient, drag_coefficient};
use raceway::physics::land::Land;
use raceway::physics::lubricant::{Lubricant, LubricantKind};

use crate::table::{check, check_computed};

/// Measured values.
#[test]
fn drag_of_a_sphere() {
    for (case, reynolds) in [
        ("drag-3", 3.02),
        ("drag-58", 57.54),
        ("drag-265", 264.9),
        ("drag-1e3", 1000.0),
        ("drag-3e3", 3162.0),
        ("drag-3e4", 3.467e4),
    ] {
        check(case, &[drag_coefficient(reynolds)]);
    }
}

#[test]
fn torque_of_a_spinning_sphere() {
    check_computed("churning-1", &[16.0 * PI], &[churning_coefficient(1.0)]);
    check("churning-100", &[churning_coefficient(100.0)]);
}

/// Load number η N L D/W (R/C)² (L/D)² with N in turns a second, and attitude angle between load and displacement, of the
/// force of a guiding land.
#[test]
fn short_bearing() {
    let oil = Lubricant {
        kind: LubricantKind::Oil,
        viscosity: 0.02,
        pressure_viscosity: 2e-8,
        fill: 0.05,
        inlet_distance: None,
        traction: TractionLaw::Coulomb { coefficient: 0.05, regularisation: 0.1 },
    };
    let (clearance, diameter, width, speed) = (100e-6, 15e-3, 1e-3, 2000.0);
    let land = Land::new(&GuidingLand { clearance, diameter, width }, &oil);
    for (case, ratio) in [("ocvirk-0.2", 0.2), ("ocvirk-0.5", 0.5), ("ocvirk-0.8", 0.8)] {
        let (force, _) = land.load([0.0, ratio * 0.5 * clearance, 0.0], speed, 0.0);
        let load = force[1].hypot(force[2]);
        let sommerfeld = oil.viscosity * speed / TAU * width * diameter / load * (diameter / clearance).powi(2);
        let attitude = force[2].abs().atan2(-force[1]).to_degrees();
        check(case, &[sommerfeld * (width / diameter).powi(2), attitude]);
    }
}
