//! Characteristic frequencies of rolling at the contact angles of the equilibrium under load.

use crate::physics::bearing::PerRaceway;
use crate::physics::kinematics::{CharacteristicFrequencies, LoadedBall, SpinAxis, rolling_frequencies};
use crate::simulation::input::scene::Scene;
use crate::simulation::model::equilibrium::equilibrium;
use crate::simulation::model::failure::SimulationError;
use crate::simulation::model::mechanism::Mechanism;
use crate::simulation::model::terms::ActiveTerms;
use crate::simulation::recording::loaded_rolling::LoadedRolling;

/// Frequencies of rolling at the loaded contact angles, for both limits of the balls' spin axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedFrequencies {
    /// No ball turns about the normal of its outer contact.
    pub outer_control: CharacteristicFrequencies,
    /// No ball turns about the normal of its inner contact.
    pub inner_control: CharacteristicFrequencies,
}

/// Frequencies at the operating speeds, from the equilibrium under loads, weights and centrifugal forces in which a run at this speed starts;
/// `None` where too few balls carry load.
pub fn loaded_frequencies(scene: &Scene, needs: &ActiveTerms) -> Result<Option<LoadedFrequencies>, SimulationError> {
    let mechanism = Mechanism::new(scene, needs);
    let speeds = scene.operating_speeds();
    let rest = equilibrium(&mechanism, speeds)?;
    let balls: Vec<(PerRaceway<f64>, LoadedBall)> = (rest.balls.iter().zip(&rest.angles).zip(rest.loads))
        .enumerate()
        .map(|(ball, ((&(_, radial), &angle), load))| {
            let orbit_radius = mechanism.pitch_radius + radial;
            let ball_radius = mechanism.ball_radius + mechanism.body(ball).oversize;
            (load, LoadedBall { orbit_radius, ball_radius, angle })
        })
        .collect();
    let mean = |ratio: &dyn Fn(&LoadedBall) -> Option<f64>| {
        let mut rolling = LoadedRolling::default();
        balls.iter().for_each(|(load, ball)| rolling.add(*load, || ratio(ball)));
        rolling.mean()
    };
    let frequencies = |axis: fn(&LoadedBall) -> SpinAxis| {
        let orbit = mean(&|ball| ball.orbit_ratio(axis(ball)))?;
        let spin = mean(&|ball| ball.spin_ratio(axis(ball)))?;
        Some(rolling_frequencies(&scene.bearing, speeds, orbit, spin))
    };
    let both = frequencies(LoadedBall::outer_control).zip(frequencies(LoadedBall::inner_control));
    Ok(both.map(|(outer_control, inner_control)| LoadedFrequencies { outer_control, inner_control }))
}
