//! Powers of all contacts, drags, drives and loads at one state, and the kinetic energy.
//!
//! A contact takes the power of its force and moment on the ball less that of the same force and moment moving with the other body. The drive of
//! a ring supplies what they would do on the ring's material less what they do on a ring that does not turn.

use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, dot, length, scale, subtract};
use crate::physics::neighbour::NeighbourLoad;
use crate::physics::pocket::PocketLoad;
use crate::physics::raceway::{RacewayContact, RacewayLoad, RelativeMotion};
use crate::physics::spindle::unbalance_force;
use crate::simulation::input::channel::BallContact;
use crate::simulation::model::dynamics::Watch;
use crate::simulation::model::mechanism::{Mechanism, Rotations};
use crate::simulation::model::system::Model;
use crate::simulation::recording::power_balance::{PowerRecorder, Powers, RacewayPowers};

/// Observer of the powers of a run.
pub(super) struct PowerObserver {
    contacts: Contacts,
    /// The raceways without inlet forces; `None` where they have none.
    without_inlet: Option<PerRaceway<RacewayContact>>,
    rates: Vec<f64>,
    recorder: PowerRecorder,
}

/// Loads of one evaluation, ball after ball: those of raceways in the orbit frame, those of pockets in the cage's, those of neighbours in the
/// inertial frame.
#[derive(Default)]
struct Contacts {
    raceways: PerRaceway<Vec<(RelativeMotion, RacewayLoad)>>,
    pockets: Vec<PocketLoad>,
    neighbours: Vec<NeighbourLoad>,
}

impl Watch for Contacts {
    fn raceway(&mut self, _: usize, side: BallContact, motion: &RelativeMotion, load: &RacewayLoad) {
        let PerRaceway { inner, outer } = &mut self.raceways;
        if side == BallContact::Inner { inner } else { outer }.push((*motion, *load));
    }

    fn pocket(&mut self, _: usize, load: &PocketLoad) {
        self.pockets.push(*load);
    }

    fn neighbour(&mut self, _: usize, load: &NeighbourLoad) {
        self.neighbours.push(*load);
    }
}

impl Contacts {
    fn clear(&mut self) {
        self.raceways.inner.clear();
        self.raceways.outer.clear();
        self.pockets.clear();
        self.neighbours.clear();
    }
}

/// A body that moves and turns at a point of it, in the inertial frame.
#[derive(Clone, Copy)]
struct Moving {
    at: Vector,
    velocity: Vector,
    turning: Vector,
}

impl Moving {
    /// Power of a force at a place and of a moment on the body.
    fn power(&self, place: Vector, force: Vector, moment: Vector) -> f64 {
        dot(force, self.velocity) + dot(add(cross(subtract(place, self.at), force), moment), self.turning)
    }
}

impl PowerObserver {
    pub(super) fn new(model: &Model) -> Self {
        let raceway = &model.mechanism().raceway;
        let has_inlet = raceway.inner.has_inlet() || raceway.outer.has_inlet();
        Self {
            contacts: Contacts::default(),
            without_inlet: has_inlet.then(|| raceway.map(RacewayContact::without_inlet)),
            rates: vec![0.0; model.mechanism().layout.dimension()],
            recorder: PowerRecorder::default(),
        }
    }

    /// Adds a state of the recorded time.
    pub(super) fn observe(&mut self, model: &Model, time: f64, state: &[f64]) {
        self.contacts.clear();
        model.derivative_watched(time, state, &mut self.rates, &mut self.contacts);
        let at = Instant { m: model.mechanism(), rotations: model.mechanism().rotations(time), time, state };
        let (powers, energy) = at.powers(&self.contacts, |motion, side| self.raceway_parts(model, motion, side));
        self.recorder.add(time, &powers, energy);
    }

    /// The recorder with its sums.
    pub(super) fn into_recorder(self) -> PowerRecorder {
        self.recorder
    }

    /// Power of the inlet's forces and of the normal load on a ball that is a sphere.
    fn raceway_parts(&self, model: &Model, (motion, load): &(RelativeMotion, RacewayLoad), side: Side) -> (f64, f64) {
        let m = model.mechanism();
        let (_, (towards_a, towards_r)) = side.of(&m.raceway).penetration::<false>(motion.axial, motion.radius);
        let normal = load.normal * (towards_a * motion.velocity[0] + towards_r * motion.velocity[1]);
        let taken = |contact: &RacewayContact| {
            let load = match model {
                Model::Planar(_) => contact.load::<true>(motion),
                Model::Full(_) => contact.load::<false>(motion),
            };
            taken_by(motion, &load)
        };
        let rolling = self.without_inlet.as_ref().filter(|_| load.normal > 0.0);
        (rolling.map_or(0.0, |without| taken(side.of(&m.raceway)) - taken(side.of(without))), normal)
    }
}

/// Power that a contact takes, in its own frame: the ball moves against a ring that turns about the first axis.
fn taken_by(motion: &RelativeMotion, load: &RacewayLoad) -> f64 {
    let turning = motion.raceway_speed;
    let [a, r, t] = motion.velocity;
    let [about_a, about_r, about_t] = motion.spin;
    -dot(load.force, [a, r, t - turning * motion.radius]) - dot(load.moment, [about_a - turning, about_r, about_t])
}

#[derive(Clone, Copy)]
enum Side {
    Inner,
    Outer,
}

impl Side {
    fn of<T>(self, pair: &PerRaceway<T>) -> &T {
        match self {
            Self::Inner => &pair.inner,
            Self::Outer => &pair.outer,
        }
    }
}

/// A state at a time.
struct Instant<'a> {
    m: &'a Mechanism,
    rotations: Rotations,
    time: f64,
    state: &'a [f64],
}

impl Instant<'_> {
    /// Powers at this state, and the kinetic energy of balls, cage and spindle without the rotation of the rings.
    fn powers(
        &self,
        contacts: &Contacts,
        parts: impl Fn(&(RelativeMotion, RacewayLoad), Side) -> (f64, f64),
    ) -> (Powers, f64) {
        let m = self.m;
        let (mut powers, mut energy) = (Powers::default(), 0.0);
        let balls: Vec<Moving> = (0..m.layout.balls).map(|ball| self.ball(ball)).collect();
        let (inner, axis) = self.inner_ring();
        let outer = Moving { at: [0.0; 3], velocity: [0.0; 3], turning: [0.0; 3] };
        for (index, body) in balls.iter().enumerate() {
            let (of_ball, azimuth) = (m.body(index), self.azimuth(index));
            energy += 0.5 * of_ball.mass * dot(body.velocity, body.velocity);
            energy += 0.5 * of_ball.inertia * dot(body.turning, body.turning);
            powers.applied += of_ball.mass * m.gravity * body.velocity[1];
            self.add_surroundings(&mut powers, index, body);
            for (side, held, about, speed) in [
                (Side::Inner, &inner, axis, self.rotations.inner.speed),
                (Side::Outer, &outer, [1.0, 0.0, 0.0], self.rotations.outer.speed),
            ] {
                let contact = &side.of(&contacts.raceways)[index];
                let [force, moment] = [contact.1.force, contact.1.moment].map(|vector| azimuth.to_inertial(vector));
                let turned = Moving { turning: add(held.turning, scale(speed, about)), ..*held };
                let against = turned.power(body.at, force, moment);
                powers.drive += against - held.power(body.at, force, moment);
                let (rolling, normal) = parts(contact, side);
                let sliding = against - body.power(body.at, force, moment) - rolling - normal;
                let one = match side {
                    Side::Inner => &mut powers.raceway.inner,
                    Side::Outer => &mut powers.raceway.outer,
                };
                let RacewayPowers { sliding: a, rolling: b, normal: c } = *one;
                *one = RacewayPowers { sliding: a + sliding, rolling: b + rolling, normal: c + normal };
            }
        }
        for (index, load) in contacts.neighbours.iter().enumerate() {
            let (one, next) = (&balls[index], &balls[(index + 1) % balls.len()]);
            let turning = dot(load.moment, add(one.turning, next.turning));
            let moving = if load.normal > 0.0 { dot(load.force, subtract(one.velocity, next.velocity)) } else { 0.0 };
            powers.neighbours -= moving + if load.normal > 0.0 { turning } else { 0.0 };
        }
        if m.layout.cage {
            energy += self.add_cage(&mut powers, &balls, &contacts.pockets);
        }
        energy += self.add_spindle(&mut powers);
        (powers, energy)
    }

    fn azimuth(&self, ball: usize) -> Azimuth {
        Azimuth::new(self.m.azimuth(ball, &self.rotations, self.m.layout.ball(self.state, ball).arc))
    }

    fn ball(&self, ball: usize) -> Moving {
        let (m, now, azimuth) = (self.m, self.m.layout.ball(self.state, ball), self.azimuth(ball));
        let (radius, orbit) = (m.pitch_radius + now.radial, m.orbit_speed(&self.rotations, now.arc_velocity));
        Moving {
            at: azimuth.to_inertial([now.axial, radius, 0.0]),
            velocity: azimuth.to_inertial([now.axial_velocity, now.radial_velocity, radius * orbit]),
            turning: azimuth.to_inertial(add(now.spin, [self.rotations.spin.speed, 0.0, 0.0])),
        }
    }

    /// The inner ring as it moves without turning, and its axis.
    fn inner_ring(&self) -> (Moving, Vector) {
        let (m, spindle) = (self.m, self.m.layout.spindle(self.state));
        let tilt = if m.layout.tilting_spindle { spindle.tilt } else { m.misalignment };
        let [axis, _, z] = Tilt::new(tilt[0], tilt[1]).columns;
        let [rate_y, rate_z] = spindle.tilt_rate;
        let inner = Moving {
            at: add(spindle.position, [m.axial_offset, 0.0, 0.0]),
            velocity: spindle.velocity,
            turning: add([0.0, rate_y, 0.0], scale(rate_z, z)),
        };
        (inner, axis)
    }

    fn add_surroundings(&self, powers: &mut Powers, ball: usize, body: &Moving) {
        let (m, now) = (self.m, self.m.layout.ball(self.state, ball));
        let orbit = m.orbit_speed(&self.rotations, now.arc_velocity);
        if let Some(drag) = m.drag {
            powers.drag -= drag.force(m.pitch_radius * orbit) * (m.pitch_radius + now.radial) * orbit;
        }
        if let Some(churning) = m.churning {
            powers.churning += churning.churning_factor(length(body.turning)) * dot(body.turning, body.turning);
        }
    }

    /// Adds the powers of pockets, land and weight of the cage, and returns its kinetic energy.
    fn add_cage(&self, powers: &mut Powers, balls: &[Moving], pockets: &[PocketLoad]) -> f64 {
        let (m, cage) = (self.m, self.m.layout.cage(self.state));
        let tilt = if m.layout.planar { Tilt::NONE } else { Tilt::new(cage.tilt[0], cage.tilt[1]) };
        let turned = [m.orbit_speed(&self.rotations, cage.arc_velocity), cage.tilt_rate[0], cage.tilt_rate[1]];
        let carried = Moving {
            at: [cage.centre[0] - m.cage.offset, cage.centre[1], cage.centre[2]],
            velocity: cage.velocity,
            turning: tilt.to_inertial(turned),
        };
        for (body, load) in balls.iter().zip(pockets) {
            let [force, moment] = [load.force, load.moment].map(|vector| tilt.to_inertial(vector));
            let at = add(body.at, tilt.to_inertial(load.lever));
            powers.pockets -= body.power(body.at, force, moment) - carried.power(at, force, [0.0; 3]);
        }
        if let Some(land) = &m.land {
            let ring = self.rotations.outer.speed;
            let (force, braking) = land.load(carried.at, turned[0], ring);
            let against = ring * (cross(carried.at, force)[0] + braking);
            powers.land -= dot(force, cage.velocity) + braking * turned[0] - against;
            powers.drive += against;
        }
        powers.applied += m.cage.mass * m.gravity * cage.velocity[1];
        let [about_x, about_y, about_z] = turned.map(|speed| speed * speed);
        let turning = m.cage.axial_inertia * about_x + m.cage.transverse_inertia * (about_y + about_z);
        0.5 * (m.cage.mass * dot(cage.velocity, cage.velocity) + turning)
    }

    /// Adds the power of the loads, the unbalance and the weight of the spindle, and returns its kinetic energy without its rotation.
    fn add_spindle(&self, powers: &mut Powers) -> f64 {
        let (m, spindle) = (self.m, self.m.layout.spindle(self.state));
        let turn = self.rotations.inner;
        let mut force = m.load;
        force[1] += m.spindle_mass * m.gravity;
        if m.unbalance != 0.0 {
            force = add(force, unbalance_force(m.unbalance, turn.angle, turn.speed, turn.acceleration));
        }
        let mut moment = m.moment;
        if let Some([x, y, z, about_y, about_z]) = m.load_change(self.time, turn.angle) {
            force = add(force, [x, y, z]);
            moment = [moment[0] + about_y, moment[1] + about_z];
        }
        let [rate_y, rate_z] = spindle.tilt_rate;
        powers.applied += dot(force, spindle.velocity);
        let inertia = m.spindle_inertia.map_or(0.0, |inertia| inertia.transverse);
        if inertia > 0.0 {
            powers.applied += moment[0] * rate_y + moment[1] * rate_z;
        }
        0.5 * (m.spindle_mass * dot(spindle.velocity, spindle.velocity) + inertia * (rate_y * rate_y + rate_z * rate_z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random::SplitMix64;
    use crate::physics::friction_reference::{Running, Supply};
    use crate::physics::presets;
    use crate::simulation::input::control::Control;
    use crate::simulation::input::model_level::ModelLevel;
    use crate::simulation::input::scene::{Scene, Term, TermChoice};
    use crate::simulation::input::settings::{Outputs, RunSettings};
    use crate::simulation::model::equilibrium::start_state;
    use crate::simulation::model::terms::ActiveTerms;
    use crate::simulation::result::metrics::FrictionTorque;
    use crate::simulation::solve::run::simulate;

    /// One revolution per minute [rad/s].
    const RPM: f64 = std::f64::consts::TAU / 60.0;

    fn scene(name: &str, speed: f64, load: Vector) -> Scene {
        Scene::of_preset(&presets::bearing(name).unwrap(), speed * RPM, load).unwrap()
    }

    fn in_oil(mut scene: Scene) -> Scene {
        scene.lubricant = presets::lubricant("oil").unwrap();
        scene
    }

    fn outputs() -> Outputs {
        Outputs { friction: true, life: true, ..Outputs::vibration() }
    }

    fn model(scene: &Scene, level: ModelLevel) -> Model {
        Model::new(scene, &ActiveTerms::of(scene, &outputs(), Some(level)).unwrap())
    }

    /// The equilibrium with displacements of micrometres and velocities of tenths of a metre a second.
    fn disturbed(model: &Model, seed: u64) -> Vec<f64> {
        let mut random = SplitMix64::new(seed);
        let m = model.mechanism();
        let mut state = start_state(model).unwrap();
        let names = m.layout.sizes();
        state.iter_mut().zip(names).for_each(|(entry, size)| *entry += size * (2.0 * random.uniform() - 1.0));
        state
    }

    /// At any state drives, loads and weights supply what is lost and the rise of the kinetic energy, to 1e-5 of the largest power: the
    /// quotient of differences has no more digits.
    #[test]
    fn powers_are_the_rate_of_the_energy() {
        let with_land = |mut scene: Scene| {
            scene.cage.land = Some(crate::physics::cage::GuidingLand { clearance: 2e-4, diameter: 44e-3, width: 2e-3 });
            scene
        };
        let without_cage = |mut scene: Scene| {
            scene.terms.set(Term::Cage, TermChoice::Off);
            scene
        };
        let scenes = [
            (scene("article-integrated", 50e3, [0.0, 200.0, 0.0]), ModelLevel::Planar),
            (in_oil(scene("6205", 3e3, [200.0, 500.0, 0.0])), ModelLevel::Full),
            (with_land(in_oil(scene("6205", 3e3, [200.0, 500.0, 0.0]))), ModelLevel::Full),
            (without_cage(scene("6205", 3e3, [0.0, 500.0, 0.0])), ModelLevel::Full),
        ];
        for (index, (scene, level)) in scenes.iter().enumerate() {
            let model = model(scene, *level);
            for seed in 1..4 {
                let (time, step) = (1e-3, 1e-10);
                let state = disturbed(&model, seed);
                let mut observer = PowerObserver::new(&model);
                let mut at = |time: f64, state: &[f64]| {
                    observer.recorder = PowerRecorder::default();
                    observer.contacts.clear();
                    model.derivative_watched(time, state, &mut observer.rates, &mut observer.contacts);
                    let m = model.mechanism();
                    let instant = Instant { m, rotations: m.rotations(time), time, state };
                    let parts =
                        |motion: &(RelativeMotion, RacewayLoad), side| observer.raceway_parts(&model, motion, side);
                    (instant.powers(&observer.contacts, parts), observer.rates.clone())
                };
                let ((powers, _), rates) = at(time, &state);
                let moved = |by: f64| -> Vec<f64> { state.iter().zip(&rates).map(|(y, rate)| y + by * rate).collect() };
                let ((_, after), _) = at(time + step, &moved(step));
                let ((_, before), _) = at(time - step, &moved(-step));
                let rise = (after - before) / (2.0 * step);
                let gap = powers.drive + powers.applied - powers.losses() - rise;
                let largest = powers.drive.abs().max(powers.losses().abs()).max(rise.abs());
                assert!(gap.abs() < 1e-5 * largest, "scene {index}, state {seed}: {gap} W of {largest}, {powers:?}");
                assert!(powers.churning >= 0.0 && powers.drag >= 0.0, "{powers:?}");
            }
        }
    }

    fn friction(scene: &Scene, duration: f64) -> FrictionTorque {
        let settings = RunSettings::new(0.02, duration, outputs());
        simulate(scene, &settings, &Control::until(&|| false)).unwrap().summary.friction.unwrap()
    }

    /// Parts of the torque add up to that of the drives less what is stored, to 1e-3. Beside the model of SKF the sum is 1.4 times smaller at 500 N and
    /// 2.3 times at 1000 N; sliding and rolling grow with the load as they do there.
    #[test]
    fn torque_of_the_parts_is_that_of_the_drive() {
        let of = |load: f64| friction(&in_oil(scene("6205", 3e3, [0.0, load, 0.0])), 0.1);
        let (light, heavy) = (of(500.0), of(1000.0));
        for torque in [&light, &heavy] {
            let balance = &torque.powers;
            assert!(balance.mean.drive > 0.0 && balance.gap().abs() < 1e-3 * balance.mean.drive, "{balance:?}");
        }
        let parts = |torque: &FrictionTorque| {
            let PerRaceway { inner, outer } = torque.powers.mean.raceway;
            [inner.sliding + outer.sliding, inner.rolling + outer.rolling].map(|power| 1e3 * torque.of(power))
        };
        for (torque, radial, least) in [(&light, 500.0, 0.5), (&heavy, 1000.0, 0.4)] {
            // 13 mPa s at 900 kg/m³.
            let running = Running {
                bore: 25.0,
                outside: 52.0,
                static_rating: 7850.0,
                radial,
                axial: 0.0,
                speed: 3000.0,
                viscosity: 14.444,
            };
            let skf = running.skf("62", Supply::OilBath).unwrap();
            let ratio = 1e3 * torque.of(torque.powers.mean.losses()) / (skf.rolling + skf.sliding);
            assert!((least..1.0).contains(&ratio), "{radial} N: {ratio}");
        }
        assert!(parts(&heavy)[0] > parts(&light)[0] && parts(&heavy)[1] > parts(&light)[1]);
    }

    /// The article's bearing on the leanest level of the dynamics, which observes the ends of steps.
    #[test]
    fn torque_closes_on_planar_dynamics() {
        let torque = friction(&scene("article-integrated", 50e3, [0.0, 200.0, 0.0]), 0.05);
        let balance = &torque.powers;
        assert!(balance.gap().abs() < 1e-3 * balance.mean.drive, "{balance:?}");
    }
}
