//! Problems that several methods are tested on.

use super::integrator::IntegrationError;
use super::method::Method;
use super::structure::Structure;
use super::system::OdeSystem;
use super::tolerances::Tolerances;

/// Two bodies: a nonlinear problem with an exact period.
pub(crate) struct Kepler;
impl OdeSystem for Kepler {
    fn dimension(&self) -> usize {
        4
    }
    fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
        let cube = (y[0] * y[0] + y[1] * y[1]).powf(1.5);
        dy.copy_from_slice(&[y[2], y[3], -y[0] / cube, -y[1] / cube]);
    }
    fn structure(&self) -> Structure {
        Structure { border_pairs: vec![(0, 2), (1, 3)], ..Structure::dense(4) }
    }
}
pub const START: [f64; 4] = [0.5, 0.0, 0.0, 1.732_050_807_568_877_2];

/// A decay beside y' = y², which from y(0) = 1 leaves the real numbers at t = 1.
pub struct BlowUp;
impl OdeSystem for BlowUp {
    fn dimension(&self) -> usize {
        2
    }
    fn derivative(&self, _time: f64, y: &[f64], dy: &mut [f64]) {
        dy.copy_from_slice(&[-y[0], y[1] * y[1]]);
    }
}

#[test]
fn a_pole_is_a_failure_that_names_time_and_component() {
    for method in [Method::DormandPrince, Method::Gear, Method::Radau] {
        let mut integrator = method.start(&BlowUp, 0.0, &[1.0, 1.0], Tolerances::uniform(2, 1e-8, 1e-8), None);
        let failure = loop {
            if let Err(failure) = integrator.step(2.0) {
                break failure;
            }
        };
        match failure {
            IntegrationError::StepTooSmall { time, component, .. }
            | IntegrationError::NotFinite { time, component, .. } => {
                assert!((time - 1.0).abs() < 1e-3, "{method:?}: {time}");
                assert_eq!(component, 1, "{method:?}");
            }
            other => panic!("{method:?}: {other}"),
        }
    }
}
