//! Balance of powers at one instant: what the drives, weights and dampers supply and the contacts take is the rate of the energy.

use super::housing::{in_seats, turning};
use super::*;
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::{Azimuth, Tilt, Vector, add, cross, length, scale, subtract};
use crate::physics::pocket::PocketLoad;

/// Loads of the contacts of a bearing, ball after ball; those of raceways in the orbit frame, those of pockets in the cage's.
#[derive(Default)]
struct Contacts {
    raceways: PerRaceway<Vec<RacewayLoad>>,
    pockets: Vec<PocketLoad>,
}

impl Watch for Contacts {
    fn raceway(&mut self, _: usize, side: BallContact, _: &RelativeMotion, load: &RacewayLoad) {
        let PerRaceway { inner, outer } = &mut self.raceways;
        if side == BallContact::Inner { inner } else { outer }.push(*load);
    }

    fn pocket(&mut self, _: usize, load: &PocketLoad) {
        self.pockets.push(*load);
    }
}

/// Powers by their cause [W].
#[derive(Default)]
struct Powers(Vec<(&'static str, f64)>);

impl Powers {
    fn add(&mut self, cause: &'static str, power: f64) {
        self.0.push((cause, power));
    }

    fn total(&self) -> f64 {
        self.0.iter().map(|(_, power)| power).sum()
    }

    fn largest(&self) -> f64 {
        self.0.iter().fold(0.0, |most, (_, power)| f64::max(most, power.abs()))
    }

    /// Power of all causes but inertia and bending, which store energy.
    fn done(&self) -> f64 {
        const STORED: [&str; 4] = ["inertia of balls", "inertia of cages", "inertia of the shaft", "bending"];
        self.0.iter().filter(|(cause, _)| !STORED.contains(cause)).map(|(_, power)| power).sum()
    }

    /// Sum of the magnitudes of a cause.
    fn of(&self, cause: &str) -> f64 {
        self.0.iter().filter(|(of, _)| *of == cause).map(|(_, power)| power.abs()).sum()
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

/// Adds the powers on a bearing, and of its drives, at a time [s], and the rates of its kinetic energies with the sign changed.
fn add_bearing(
    powers: &mut Powers,
    dynamics: &MachineDynamics,
    time: f64,
    index: usize,
    (part, rates): (&[f64], &[f64]),
    (place, velocity): (&[f64], &[f64]),
) {
    let full = &dynamics.bearings[index].dynamics;
    let (m, rings) = (full.mechanism(), dynamics.rings(index, place, velocity));
    let ring = rings.inner;
    let mut contacts = Contacts::default();
    full.rates_on_ring(time, part, rings, &mut vec![0.0; part.len()], Some(&mut contacts));
    let ideal = m.rotations(time);
    let [axis, _, z] = Tilt::new(ring.tilt[0], ring.tilt[1]).columns;
    let tilting = add([0.0, ring.tilt_rate[0], 0.0], scale(ring.tilt_rate[1], z));
    let inner =
        Moving { at: add(ring.position, [m.axial_offset, 0.0, 0.0]), velocity: ring.velocity, turning: tilting };
    let outer_ring = rings.outer.unwrap_or_default();
    let [outer_axis, _, outer_z] = Tilt::new(outer_ring.tilt[0], outer_ring.tilt[1]).columns;
    let outer = Moving {
        at: outer_ring.position,
        velocity: outer_ring.velocity,
        turning: add([0.0, outer_ring.tilt_rate[0], 0.0], scale(outer_ring.tilt_rate[1], outer_z)),
    };
    let (cage, cage_rates) = (m.layout.cage(part), m.layout.cage(rates));
    let cage_tilt = Tilt::new(cage.tilt[0], cage.tilt[1]);
    let spin = m.orbit_speed(&ideal, cage.arc_velocity);
    let carried = Moving {
        at: [cage.centre[0] - m.cage.offset, cage.centre[1], cage.centre[2]],
        velocity: cage.velocity,
        turning: cage_tilt.to_inertial([spin, cage.tilt_rate[0], cage.tilt_rate[1]]),
    };
    for ball in 0..m.layout.balls {
        let (now, rate) = (m.layout.ball(part, ball), m.layout.ball(rates, ball));
        let azimuth = Azimuth::new(m.azimuth(ball, &ideal, now.arc));
        let (radius, orbit) = (m.pitch_radius + now.radial, m.orbit_speed(&ideal, now.arc_velocity));
        let local = [now.axial_velocity, now.radial_velocity, radius * orbit];
        let turning = add(now.spin, [ideal.spin.speed, 0.0, 0.0]);
        let body = Moving {
            at: azimuth.to_inertial([now.axial, radius, 0.0]),
            velocity: azimuth.to_inertial(local),
            turning: azimuth.to_inertial(turning),
        };
        // v·dv/dt = ẋ ẍ + ṙ r̈ + r θ̇ (ṙ θ̇ + r θ̈) in the turning frame, and ω·dω/dt alike.
        let orbit_rate = ideal.orbit.acceleration + rate.arc_velocity / m.pitch_radius;
        let along = now.radial_velocity * orbit + radius * orbit_rate;
        let accelerated = dot(local, [rate.axial_velocity, rate.radial_velocity, along]);
        let spun = dot(turning, add(rate.spin, [ideal.spin.acceleration, 0.0, 0.0]));
        powers.add("inertia of balls", -m.ball_mass * accelerated);
        powers.add("inertia of balls", -m.ball_inertia * spun);
        powers.add("weight", m.ball_mass * m.gravity * body.velocity[1]);
        if let Some(drag) = m.drag {
            powers.add("drag", drag.force(m.pitch_radius * orbit) * local[2]);
        }
        if let Some(churning) = m.churning {
            powers.add("churning", -churning.churning_factor(length(turning)) * dot(turning, turning));
        }
        for (load, held, about, speed) in [
            (&contacts.raceways.inner[ball], &inner, axis, ideal.inner.speed),
            (&contacts.raceways.outer[ball], &outer, outer_axis, ideal.outer.speed),
        ] {
            let [force, moment] = [load.force, load.moment].map(|vector| azimuth.to_inertial(vector));
            let turned = Moving { turning: add(held.turning, scale(speed, about)), ..*held };
            let against = turned.power(body.at, force, moment);
            powers.add("raceways", body.power(body.at, force, moment) - against);
            // The drive turns the ring against the balls.
            powers.add("drives", against - held.power(body.at, force, moment));
        }
        if m.layout.cage {
            let load = &contacts.pockets[ball];
            let [force, moment] = [load.force, load.moment].map(|vector| cage_tilt.to_inertial(vector));
            let at = add(body.at, cage_tilt.to_inertial(load.lever));
            powers.add("pockets", body.power(body.at, force, moment) - carried.power(at, force, [0.0; 3]));
        }
    }
    if m.layout.cage {
        let turned = [spin, cage.tilt_rate[0], cage.tilt_rate[1]];
        let spun = ideal.orbit.acceleration + cage_rates.arc_velocity / m.pitch_radius;
        powers.add("inertia of cages", -m.cage.mass * dot(cage.velocity, cage_rates.velocity));
        powers.add("inertia of cages", -m.cage.axial_inertia * turned[0] * spun);
        for axis in 0..2 {
            let rate = cage_rates.tilt_rate[axis];
            powers.add("inertia of cages", -m.cage.transverse_inertia * turned[axis + 1] * rate);
        }
        powers.add("weight", m.cage.mass * m.gravity * cage.velocity[1]);
    }
}

/// Adds the powers on the shaft at a time [s] but those of its bearings, and the rate of its energy with the sign changed.
fn add_shaft(powers: &mut Powers, dynamics: &MachineDynamics, time: f64, state: &[f64], rates: &[f64]) {
    let (frame, (place, velocity)) = (&dynamics.frame, dynamics.coordinates(state));
    let (_, acceleration) = dynamics.coordinates(rates);
    let turning = dynamics.speed.at(time);
    let mut inputs = vec![0.0; frame.inputs.ncols()];
    frame.write_loads(time, turning, &mut inputs);
    let [stiffness, damping] = frame.matrices(turning.1);
    let [place, velocity] = [place, velocity].map(DVector::from_row_slice);
    let forces = [
        ("inertia of the shaft", -DVector::from_row_slice(acceleration)),
        ("bending", -(stiffness * place)),
        ("damping of the shaft", -(damping * &velocity)),
        ("loads of the shaft", &frame.inputs * DVector::from_vec(inputs)),
    ];
    for (cause, forces) in forces {
        velocity.iter().zip(&forces).for_each(|(velocity, force)| powers.add(cause, velocity * force));
    }
}

/// All powers at a time [s], in a state with its rates.
fn powers(dynamics: &MachineDynamics, time: f64, state: &[f64], rates: &[f64]) -> Powers {
    let mut powers = Powers::default();
    add_shaft(&mut powers, dynamics, time, state, rates);
    let coordinates = dynamics.coordinates(state);
    for (index, parts) in dynamics.parts(state).into_iter().zip(dynamics.parts(rates)).enumerate() {
        add_bearing(&mut powers, dynamics, time, index, parts, coordinates);
    }
    powers
}

/// A state far from equilibrium: balls and cages are displaced by micrometres and move by tenths of a metre a second, the shaft bends, tilts and
/// moves.
fn far_from_rest(start: &[f64], dynamics: &MachineDynamics, seed: u64) -> Vec<f64> {
    let mut random = SplitMix64::new(seed);
    let mut spread = |size: f64| size * (2.0 * random.uniform() - 1.0);
    let mut state = Vec::with_capacity(start.len());
    for (part, bearing) in dynamics.parts(start).into_iter().zip(&dynamics.bearings) {
        let m = bearing.dynamics.mechanism();
        let mut part = part.to_vec();
        for index in 0..m.layout.balls {
            let mut ball = m.layout.ball(&part, index);
            ball.axial += spread(3e-6);
            ball.radial += spread(3e-6);
            ball.arc += spread(4e-5);
            ball.axial_velocity += spread(0.2);
            ball.radial_velocity += spread(0.2);
            ball.arc_velocity += spread(0.2);
            ball.spin = ball.spin.map(|spin| spin + spread(300.0));
            m.layout.set_ball(&mut part, index, &ball);
        }
        let mut cage = m.layout.cage(&part);
        cage.centre = cage.centre.map(|_| spread(5e-5));
        cage.velocity = cage.velocity.map(|_| spread(0.2));
        cage.tilt = cage.tilt.map(|_| spread(1e-3));
        cage.tilt_rate = cage.tilt_rate.map(|_| spread(30.0));
        cage.arc_velocity = spread(0.2);
        m.layout.set_cage(&mut part, &cage);
        state.extend(part);
    }
    let size = dynamics.frame.len();
    let (place, velocity) = dynamics.coordinates(start);
    let frequency = |k: usize| frequency_of(&dynamics.frame, k).max(1e4);
    state.extend(place.iter().enumerate().map(|(k, value)| value + spread(3e-2 / frequency(k))));
    state.extend(velocity.iter().map(|value| value + spread(0.1)));
    assert_eq!(state.len() - 2 * size, start.len() - 2 * size);
    state
}

/// At any state of a tilting, flexible shaft on two bearings that face each other, all powers sum to the rate of the energy: to 1e-12 of the
/// largest. The rings turn against each other, cages tilt, and every force acts. Outer rings are held, or turn and move in their seats.
#[test]
fn powers_sum_to_the_rate_of_the_energy() {
    powers_are_balanced(|machine| machine);
    powers_are_balanced(in_seats);
}

fn powers_are_balanced(change: impl Fn(Machine) -> Machine) {
    let mut machine = motor_spindle();
    machine.rotor.load = [60.0, 100.0, -30.0];
    machine.rotor.unbalances[0].at = 0.2;
    machine.rotor.shaft.discs[0].at = 0.12;
    for bearing in &mut machine.bearings {
        for term in [Term::Drag, Term::Churning, Term::Hydrodynamics] {
            bearing.scene.terms.set(term, TermChoice::On);
        }
    }
    let machine = turning(change(machine), -2500.0 * RPM);
    let (dynamics, start) = started(&machine);
    for seed in 1..=20 {
        let state = far_from_rest(&start, &dynamics, seed);
        let mut rates = vec![0.0; state.len()];
        dynamics.derivative(0.0, &state, &mut rates);
        let powers = powers(&dynamics, 0.0, &state, &rates);
        let (off, largest) = (powers.total(), powers.largest());
        assert!(off.abs() < 1e-12 * largest, "state {seed}: {off:e} W of {largest:e} W");
        // Each cause matters in these states.
        for cause in ["raceways", "drives", "pockets", "weight", "drag", "churning", "bending", "damping of the shaft"]
        {
            assert!(powers.of(cause) > 1e6 * off.abs(), "state {seed}: {cause} {:e} W, {off:e}", powers.of(cause));
        }
    }
}

/// A machine's state, then the work done on it and that of its drives [J].
struct WithWork<'a>(&'a MachineDynamics);

impl OdeSystem for WithWork<'_> {
    fn dimension(&self) -> usize {
        self.0.dimension() + 2
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        let (rates, works) = derivative.split_at_mut(self.0.dimension());
        let state = &state[..rates.len()];
        self.0.derivative(time, state, rates);
        let powers = powers(self.0, time, state, rates);
        works.copy_from_slice(&[powers.done(), powers.of("drives")]);
    }
}

/// Energy of a turning machine [J] without the contacts and weights, which do work.
fn energy_of_motion(dynamics: &MachineDynamics, state: &[f64]) -> f64 {
    let (place, velocity) = dynamics.coordinates(state);
    let [place, velocity] = [place, velocity].map(DVector::from_row_slice);
    let bending = place.dot(&(&dynamics.frame.matrices(0.0)[0] * &place));
    let parts = dynamics.parts(state).into_iter().zip(&dynamics.bearings);
    let of_parts: f64 = parts.map(|(part, bearing)| kinetic_energy(bearing.dynamics.mechanism(), part)).sum();
    of_parts + 0.5 * (velocity.dot(&velocity) + bending)
}

/// Over 0.1 s the energy of a flexible shaft on two bearings under every force changes by the work done: to 1e-9 of that of the drives. Steps are
/// as short as stability asks for, so that a tighter tolerance changes nothing.
#[test]
fn energy_changes_by_the_work_done() {
    let mut machine = motor_spindle();
    for bearing in &mut machine.bearings {
        for term in [Term::Drag, Term::Churning, Term::Hydrodynamics] {
            bearing.scene.terms.set(term, TermChoice::On);
        }
    }
    let (dynamics, start) = started(&machine);
    let system = WithWork(&dynamics);
    let start: Vec<f64> = start.into_iter().chain([0.0; 2]).collect();
    let mut course =
        Method::DormandPrince.start(&system, 0.0, &start, Tolerances::uniform(start.len(), 1e-5, 1e-10), None);
    while course.time() < 0.1 {
        course.step(0.1).unwrap();
    }
    let (state, works) = course.state().split_at(dynamics.dimension());
    let gained = energy_of_motion(&dynamics, state) - energy_of_motion(&dynamics, &start[..state.len()]);
    let left = (gained - works[0]).abs() / works[1];
    assert!(left < 1e-9 && works[1] > 1.0 && gained.abs() > 1e-3, "{left:e} of {works:?} J, gained {gained:e} J");
}
