//! Rung 2: the radial motion of the balls is in equilibrium between the raceways, and nothing leaves the plane.
//!
//! A ball held between its raceways follows the spindle within microseconds, far above the band of interest. What is left of
//! it are its azimuth, orbit speed and spin; its radius follows from the approach of the raceways (`contact_law.rs`), with
//! what its inertia and the damping of both contacts do to first order. Balls lie eight side by side. `stepping.rs`
//! advances the motion, `recording.rs` looks on.

mod contact_law;
mod recording;
mod stepping;
#[cfg(test)]
mod tests;
mod traction;

pub use recording::{Pace, simulate};
pub use stepping::Stepper;

use super::Mechanism;
use crate::physics::bearing::PerRaceway;
use crate::physics::cage::PocketFilm;
use crate::physics::contact::damping::{DampingFactor, VISCOUS_RAMP};
use crate::physics::contact::traction::{TractionLaw, four_parameters};
use crate::physics::frames::Azimuth;
use crate::physics::pocket::{PocketMotion, WEDGE_DAMPING};
use crate::physics::raceway::RelativeMotion;
use crate::physics::spindle::{AxialHold, unbalance_force};
use crate::simulation::channel::{Axis, Channel};
use crate::simulation::equilibrium::equilibrium;
use crate::simulation::needs::{Needs, Unmet};
use crate::simulation::run::{Outputs, Rung, SimulationError};
use crate::simulation::scene::{Scene, Term, TermChoice};
use contact_law::ContactLaw;
use traction::{RacewayTraction, RisingTraction, Slip, Sums, WIDEST, general_sums};

/// Balls side by side.
pub const WIDTH: usize = 8;

/// A number of each of eight balls.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(align(64))]
pub struct Lane(pub [f64; WIDTH]);

/// Displacement over which film damping of a pocket sets in [m]; as in `physics/pocket.rs`.
const DAMPING_ONSET: f64 = 0.1e-6;
/// Loads beyond the largest static one for which contacts count as narrow.
const LOAD_MARGIN: f64 = 1.5;

/// Eight balls: deviations from ideal rolling, as in `state.rs`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Balls {
    /// [m]
    pub arc: Lane,
    /// [m/s]
    pub arc_velocity: Lane,
    /// About X [rad/s].
    pub spin: Lane,
}

/// Spindle and cage, (y, z).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Border {
    pub spindle: [f64; 2],
    pub spindle_velocity: [f64; 2],
    pub cage: [f64; 2],
    pub cage_arc: f64,
    /// y, z, along the arc [m/s].
    pub cage_velocity: [f64; 3],
}

/// Rates of the velocities at one time, with what the implicit part needs of their derivatives.
#[derive(Debug, Clone, Default)]
pub struct Rates {
    pub balls: Vec<BallRates>,
    pub spindle: [f64; 2],
    pub cage: [f64; 3],
    /// Diagonal of the damping of the cage by its pockets [1/s], not negative.
    pub cage_damping: [f64; 3],
}

#[derive(Debug, Clone, Copy, Default)]
pub struct BallRates {
    pub arc_velocity: Lane,
    pub spin: Lane,
    /// −∂(arc rate)/∂(arc velocity), ∂(arc rate)/∂(spin), ∂(spin rate)/∂(arc velocity), −∂(spin rate)/∂(spin).
    pub matrix: [Lane; 4],
}

/// What else was seen in an evaluation.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    pub load: PerRaceway<Lane>,
    pub slip: PerRaceway<Lane>,
    pub pocket: Lane,
}

/// The equations of the rung: made once a scene.
#[derive(Debug, Clone)]
pub struct RadiallyCondensed {
    mechanism: Mechanism,
    needs: Needs,
    groups: usize,
    start: Vec<[Lane; 2]>,
    active: Vec<Lane>,
    law: ContactLaw,
    stiffness: PerRaceway<f64>,
    traction: PerRaceway<RacewayTraction>,
    /// a²/δ [m].
    axis_square: PerRaceway<f64>,
    damping: DampingFactor,
    /// Half the diametral clearance: approach of the raceways at which a weightless ball is touched [m].
    clearance: f64,
    film: Film,
    plain_pocket: bool,
    ball_radius: f64,
    /// Drag and churning, straight lines at the ideal speeds; made anew where the speed changes.
    constant_speed: bool,
    mixture: Mixture,
    root: f64,
    /// Where the spindle starts [m].
    rest: [f64; 2],
    /// Damping over mass and frequency of the spindle on its contacts at rest, as if all lay in one direction [1/s, rad/s].
    spindle_rates: [f64; 2],
    instructions: Instructions,
}

/// What the loops over eight balls are compiled for. Fused products are written as such and nothing else is contracted or
/// reordered: the bits are the same. Without the instruction a fused product is slow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instructions {
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    Baseline,
}

impl Instructions {
    /// Those of this processor, the best first.
    pub fn available() -> Vec<Self> {
        let mut all = Vec::new();
        #[cfg(target_arch = "x86_64")]
        {
            let wide = is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl");
            if is_x86_feature_detected!("avx512f") && wide && is_x86_feature_detected!("fma") {
                all.push(Self::Avx512);
            }
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                all.push(Self::Avx2);
            }
        }
        all.push(Self::Baseline);
        all
    }
}

fn unloaded_root(m: &Mechanism, speed: f64, stiffness: f64) -> f64 {
    let orbit = m.orbit_ratio * speed;
    ((m.ball_mass * (m.pitch_radius * orbit * orbit + m.gravity) + 1e-12) / stiffness).cbrt()
}

#[derive(Debug, Clone, Copy)]
struct Film {
    stiffness: f64,
    damping: f64,
    clearance: f64,
}

/// Drag [N] and churning [N m] = value + slope · deviation from the ideal orbit velocity and spin.
#[derive(Debug, Clone, Copy, Default)]
struct Mixture {
    drag: [f64; 2],
    churning: [f64; 2],
}

impl Mixture {
    fn at(m: &Mechanism, speed: f64) -> Self {
        let line = |f: &dyn Fn(f64) -> f64, at: f64| {
            let step = 1e-3 * at.abs() + 1e-9;
            [f(at), (f(at + step) - f(at - step)) / (2.0 * step)]
        };
        Self {
            drag: m.drag.map_or([0.0; 2], |drag| line(&|v| drag.force(v), m.pitch_radius * m.orbit_ratio * speed)),
            churning: m
                .churning
                .map_or([0.0; 2], |drag| line(&|w| drag.churning_moment([w, 0.0, 0.0])[0], m.spin_ratio * speed)),
        }
    }
}

/// Why a scene or its outputs cannot be had on this rung; `None`: they can.
pub fn refusal(scene: &Scene, outputs: &Outputs) -> Option<&'static str> {
    let term_on = |term| scene.terms.get(term) == TermChoice::On;
    let along_x =
        |channel: &Channel| matches!(channel, Channel::Spindle(Axis::X, _) | Channel::CageDisplacement(Axis::X));
    if scene.operation.load[0] != 0.0 {
        Some("an axial load acts")
    } else if scene.spindle.axial == AxialHold::Free {
        Some("the spindle moves along X")
    } else if matches!(scene.spindle.axial, AxialHold::Offset(offset) if offset != 0.0) {
        Some("the spindle is held off its centre along X")
    } else if scene.operation.misalignment != [0.0; 2] {
        Some("the spindle is misaligned")
    } else if term_on(Term::CageTilt) {
        Some("terms.cage_tilt is on")
    } else if term_on(Term::Axial) {
        Some("terms.axial is on")
    } else if term_on(Term::BallRadialDynamics) {
        Some("terms.ball_radial_dynamics is on")
    } else if outputs.spectra.iter().chain(&outputs.series).any(along_x) {
        Some("an output asks for motion along X")
    } else {
        None
    }
}

impl RadiallyCondensed {
    /// The model of a scene, or why it has none on this rung.
    pub fn new(scene: &Scene, outputs: &Outputs) -> Result<Self, SimulationError> {
        if let Some(reason) = refusal(scene, outputs) {
            return Err(Unmet::Rung { rung: Rung::Planar, reason: format!("radially condensed: {reason}") }.into());
        }
        let needs = Needs::of(scene, outputs, Some(Rung::Planar))?;
        let m = Mechanism::new(scene, &needs);
        let bearing = &scene.bearing;
        let balls = m.layout.balls;
        let groups = balls.div_ceil(WIDTH);
        let lane = |group: usize, value: &dyn Fn(usize) -> f64| {
            Lane(std::array::from_fn(|k| if group * WIDTH + k < balls { value(group * WIDTH + k) } else { 0.0 }))
        };
        let stiffness = m.raceway.map(|contact| contact.hertz().stiffness);
        let axis_square = m.raceway.map(|contact| contact.hertz().semi_axes(contact.hertz().stiffness).0.powi(2));
        let ball_radius = 0.5 * bearing.parameters.ball_diameter;
        let rest = equilibrium(&m, m.speed.at(0.0).1)?;
        let largest = rest.loads.iter().fold(0.0, |most, load| f64::max(most, f64::max(load.inner, load.outer)));
        let one = |contact: &crate::physics::raceway::RacewayContact| {
            let (a, _) = contact.hertz().semi_axes(LOAD_MARGIN * largest);
            match scene.lubricant.traction {
                TractionLaw::FourParameter { at_rest, maximum, at_slip, limit }
                    if at_rest == 0.0 && !needs.raceway.hydrodynamics && a * a < WIDEST * ball_radius * ball_radius =>
                {
                    let law = four_parameters(at_rest, maximum, at_slip, limit);
                    let (strips, conformity) = (needs.raceway.strips, needs.raceway.conformity);
                    let deformed = contact.hertz().deformed_radius;
                    RacewayTraction::Rising(Box::new(RisingTraction::new(
                        law,
                        strips,
                        conformity,
                        ball_radius,
                        deformed,
                    )))
                }
                _ => RacewayTraction::General,
            }
        };
        let damping = scene.raceway_damping.resolve();
        let (mut held, mut damped) = (0.0, 0.0);
        for load in rest.loads.iter().filter(|load| load.inner > 0.0) {
            // Two contacts in series: half of the slope and of the damping of one.
            let depth = (load.inner / stiffness.inner).powf(2.0 / 3.0);
            held += 0.75 * load.inner / depth;
            damped += 0.5 * (damping.chi * load.inner + damping.viscous);
        }
        let spindle_rates = [damped / m.spindle_mass, (held / m.spindle_mass).sqrt()];
        let film_damping = match scene.cage.film {
            PocketFilm::Wedge => WEDGE_DAMPING,
            PocketFilm::Given { damping, .. } => damping,
            PocketFilm::None | PocketFilm::Empirical11 => 0.0,
        };
        Ok(Self {
            start: (0..groups)
                .map(|group| [lane(group, &|ball| m.start.cosine[ball]), lane(group, &|ball| m.start.sine[ball])])
                .collect(),
            active: (0..groups).map(|group| lane(group, &|_| 1.0)).collect(),
            groups,
            law: ContactLaw::new(stiffness.inner / stiffness.outer),
            traction: m.raceway.map(one),
            axis_square,
            stiffness,
            damping,
            clearance: 0.5 * bearing.radial_clearance,
            film: Film {
                stiffness: m.pocket.film_stiffness(),
                damping: if needs.pocket.film { film_damping } else { 0.0 },
                clearance: m.pocket.clearance(),
            },
            plain_pocket: !needs.pocket.hydrodynamics,
            ball_radius,
            constant_speed: scene.operation.speed.is_constant(),
            mixture: Mixture::at(&m, m.speed.at(0.0).1),
            root: unloaded_root(&m, m.speed.at(0.0).1, stiffness.outer),
            rest: [rest.spindle[1], rest.spindle[2]],
            spindle_rates,
            instructions: Instructions::available()[0],
            mechanism: m,
            needs,
        })
    }

    /// The same with loops compiled for other instructions, which must be available.
    pub fn with_instructions(self, instructions: Instructions) -> Self {
        assert!(Instructions::available().contains(&instructions), "{instructions:?} is not here");
        Self { instructions, ..self }
    }

    pub fn instructions(&self) -> Instructions {
        self.instructions
    }

    pub fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    fn pockets_are_damped(&self) -> bool {
        self.film.damping > 0.0
    }

    pub fn needs(&self) -> &Needs {
        &self.needs
    }

    pub fn groups(&self) -> usize {
        self.groups
    }

    /// First-order states of the scene on this rung.
    pub fn states(&self) -> usize {
        3 * self.mechanism.layout.balls + if self.mechanism.layout.cage { 6 } else { 0 } + 4
    }

    /// Spindle in equilibrium under load, gravity and centrifugal force; balls rolling ideally, cage centred.
    pub fn start(&self) -> (Vec<Balls>, Border) {
        let border = Border { spindle: self.rest, ..Border::default() };
        (vec![Balls::default(); self.groups], border)
    }

    /// Rates at a time [s], and what was seen of each group of balls.
    #[inline(always)]
    pub fn rates(&self, time: f64, balls: &[Balls], border: &Border, rates: &mut Rates, scratch: &mut Scratch) {
        let instructions = self.instructions;
        let m = &self.mechanism;
        let (angle, speed, acceleration) = m.speed.at(time);
        let mixture = if self.constant_speed { self.mixture } else { Mixture::at(m, speed) };
        let ideal = scratch.turn.to(m.orbit_ratio * angle + border.cage_arc / m.pitch_radius);
        let drive = Drive { speed, acceleration, angle, ideal, mixture, root: self.root_of(speed) };
        let mut sums = BorderSums::default();
        for group in 0..self.groups {
            let (balls, rates) = (&balls[group], &mut rates.balls[group]);
            let Scratch { seen, locals: l, .. } = scratch;
            let seen = &mut seen[group];
            match instructions {
                #[cfg(target_arch = "x86_64")]
                // SAFETY: the processor has what the function is compiled for.
                Instructions::Avx512 => unsafe {
                    self.group_avx512(&drive, group, balls, border, rates, &mut sums, seen, l)
                },
                #[cfg(target_arch = "x86_64")]
                // SAFETY: as above.
                Instructions::Avx2 => unsafe {
                    self.group_avx2(&drive, group, balls, border, rates, &mut sums, seen, l)
                },
                Instructions::Baseline => self.group(&drive, group, balls, border, rates, &mut sums, seen, l),
            }
        }
        self.border_rates(&drive, border, &sums, rates);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512vl,fma")]
    #[allow(clippy::too_many_arguments)]
    fn group_avx512(
        &self,
        drive: &Drive,
        group: usize,
        balls: &Balls,
        border: &Border,
        rates: &mut BallRates,
        sums: &mut BorderSums,
        seen: &mut Seen,
        l: &mut Locals,
    ) {
        self.group(drive, group, balls, border, rates, sums, seen, l);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    #[allow(clippy::too_many_arguments)]
    fn group_avx2(
        &self,
        drive: &Drive,
        group: usize,
        balls: &Balls,
        border: &Border,
        rates: &mut BallRates,
        sums: &mut BorderSums,
        seen: &mut Seen,
        l: &mut Locals,
    ) {
        self.group(drive, group, balls, border, rates, sums, seen, l);
    }

    /// √δ of the outer contact under the centrifugal force of the ideal orbit: where the cube root of each ball starts.
    fn root_of(&self, speed: f64) -> f64 {
        if self.constant_speed {
            return self.root;
        }
        unloaded_root(&self.mechanism, speed, self.stiffness.outer)
    }

    fn border_rates(&self, drive: &Drive, border: &Border, sums: &BorderSums, rates: &mut Rates) {
        let m = &self.mechanism;
        let mut force = [m.load[1] + m.spindle_mass * m.gravity + sums.force[0], m.load[2] + sums.force[1]];
        if m.unbalance != 0.0 {
            let [_, y, z] = unbalance_force(m.unbalance, drive.angle, drive.speed, drive.acceleration);
            force = [force[0] + y, force[1] + z];
        }
        let (yy, yz, zz) = (m.spindle_mass + sums.mass[0], sums.mass[1], m.spindle_mass + sums.mass[2]);
        let inverse = 1.0 / (yy * zz - yz * yz);
        rates.spindle = [inverse * (zz * force[0] - yz * force[1]), inverse * (yy * force[1] - yz * force[0])];
        if !m.layout.cage {
            return;
        }
        let mut cage_force = [sums.cage[0], sums.cage[1]];
        let mut moment = sums.cage[2];
        if let Some(land) = &m.land {
            let spin = m.orbit_ratio * drive.speed + border.cage_velocity[2] / m.pitch_radius;
            let ([_, y, z], braking) = land.load([0.0, border.cage[0], border.cage[1]], spin);
            cage_force = [cage_force[0] + y, cage_force[1] + z];
            moment += braking;
        }
        let (per_mass, per_inertia) = (1.0 / m.cage.mass, 1.0 / m.cage.axial_inertia);
        rates.cage = [
            cage_force[0] * per_mass + m.gravity,
            cage_force[1] * per_mass,
            m.pitch_radius * (moment * per_inertia - m.orbit_ratio * drive.acceleration),
        ];
        let arm_2 = m.pitch_radius * m.pitch_radius;
        rates.cage_damping =
            [sums.damping[0] * per_mass, sums.damping[1] * per_mass, sums.damping[2] * arm_2 * per_inertia];
    }

    /// Rates of eight balls, and what they pass on.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn group(
        &self,
        drive: &Drive,
        group: usize,
        balls: &Balls,
        border: &Border,
        rates: &mut BallRates,
        sums: &mut BorderSums,
        seen: &mut Seen,
        l: &mut Locals,
    ) {
        let m = &self.mechanism;
        let active = &self.active[group];
        let per_radius = 1.0 / m.pitch_radius;

        // Where the balls are: ahead of the cage by a small angle.
        if m.layout.cage {
            for k in 0..WIDTH {
                let x = (balls.arc.0[k] - border.cage_arc) * per_radius;
                let x2 = x * x;
                l.ahead_cosine.0[k] = 1.0 - x2 * (0.5 - x2 * (1.0 / 24.0 - x2 * (1.0 / 720.0 - x2 * (1.0 / 40_320.0))));
                l.ahead_sine.0[k] =
                    x * (1.0 - x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5_040.0 - x2 * (1.0 / 362_880.0)))));
            }
        } else {
            turned(&balls.arc, per_radius, &mut l.ahead_sine, &mut l.ahead_cosine);
        }
        self.approach(drive, &self.start[group], active, balls, border, l);
        if m.layout.cage {
            self.pockets(border, balls, drive, active, l);
        }

        self.slips(drive, active, balls, border, l);
        let inner = self.traction(true, l, drive, balls);
        let outer = self.traction(false, l, drive, balls);

        self.ball_rates(drive, active, balls, &inner, &outer, rates, l);
        sums.force[0] += total(&l.spindle_y);
        sums.force[1] += total(&l.spindle_z);
        sums.mass[0] += total(&l.mass_yy);
        sums.mass[1] += total(&l.mass_yz);
        sums.mass[2] += total(&l.mass_zz);
        if m.layout.cage {
            for i in 0..3 {
                sums.cage[i] += total(&l.cage[i]);
                sums.damping[i] += total(&l.cage_damping[i]);
            }
        }
        *seen = Seen {
            load: PerRaceway { inner: l.inner_load, outer: l.outer_load },
            slip: PerRaceway { inner: inner.slip, outer: outer.slip },
            pocket: l.pocket_load,
        };
    }

    /// Places of eight balls, the approach of the raceways there, and both contacts.
    #[inline(always)]
    fn approach(
        &self,
        drive: &Drive,
        [start_cosine, start_sine]: &[Lane; 2],
        active: &Lane,
        balls: &Balls,
        border: &Border,
        l: &mut Locals,
    ) {
        let m = &self.mechanism;
        let per_radius = 1.0 / m.pitch_radius;
        let (k_i, k_e) = (self.stiffness.inner, self.stiffness.outer);
        let (guess, per_outer) = (drive.root, 1.0 / k_e);
        let mass = m.ball_mass;
        let weight = mass * m.gravity;
        let ([sy, sz], [svy, svz]) = (border.spindle, border.spindle_velocity);
        let outer_clearance = 0.5 * self.clearance;
        let ideal_orbit = m.orbit_ratio * drive.speed;
        for k in 0..WIDTH {
            let pocket_cosine = start_cosine.0[k] * drive.ideal.cosine - start_sine.0[k] * drive.ideal.sine;
            let pocket_sine = start_sine.0[k] * drive.ideal.cosine + start_cosine.0[k] * drive.ideal.sine;
            l.pocket_cosine.0[k] = pocket_cosine;
            l.pocket_sine.0[k] = pocket_sine;
            let cosine = pocket_cosine * l.ahead_cosine.0[k] - pocket_sine * l.ahead_sine.0[k];
            let sine = pocket_sine * l.ahead_cosine.0[k] + pocket_cosine * l.ahead_sine.0[k];
            l.cosine.0[k] = cosine;
            l.sine.0[k] = sine;

            // Radial force that no contact gives, and what the outer contact yields under it alone.
            let orbit = ideal_orbit + balls.arc_velocity.0[k] * per_radius;
            l.orbit.0[k] = orbit;
            let nominal = m.pitch_radius + outer_clearance;
            let body = mass * nominal * orbit * orbit + weight * cosine;
            let body = positive(body);
            l.body.0[k] = body;
            // ∛ by a step of Halley from its value on the ideal orbit, near which it stays.
            let cube = body * per_outer;
            let c = guess * guess * guess;
            let root = guess * (c + 2.0 * cube) / (2.0 * c + cube);
            let unloaded = root * root;

            // Approach of the raceways and its rate; the spindle's displacement across counts to second order.
            let across = sz * cosine - sy * sine;
            let along = sy * cosine + sz * sine;
            let across_velocity = svz * cosine - svy * sine;
            let along_velocity = svy * cosine + svz * sine;
            let from_spindle = nominal + unloaded - along;
            let lean = across / from_spindle;
            let approach = along - 0.5 * across * lean - self.clearance;
            let rate = along_velocity + lean * ((nominal + unloaded) * orbit - across_velocity);
            l.lean.0[k] = lean;
            l.along.0[k] = along;
            l.across_velocity.0[k] = across_velocity;

            // Both contacts, elastic.
            let excess = approach - unloaded;
            let pressed = positive(excess);
            let u = pressed.sqrt();
            let inner_root = self.law.inner_root(u, root) * active.0[k];
            let inner = inner_root * inner_root;
            let outer = unloaded + pressed - inner;
            let outer_root = outer.sqrt();
            let elastic = k_i * inner * inner_root;
            let outer_elastic = elastic + body;
            let per_stiffness = 1.0 / (k_i * inner_root + k_e * outer_root + 1e-30);
            let outer_share = k_i * inner_root * per_stiffness;
            let inner_share = 1.0 - outer_share;
            l.inner.0[k] = inner;
            l.outer.0[k] = outer;
            l.outer_share.0[k] = outer_share;
            l.radial_velocity.0[k] = outer_share * rate;
            l.radius.0[k] = nominal + outer;

            // Damping, energy-consistent; inertia of the ball's own motion, without the spindle's acceleration.
            let ramp = |depth: f64| {
                let s = 1.0 - positive(1.0 - depth * (1.0 / VISCOUS_RAMP));
                self.damping.viscous * s * s * (3.0 - 2.0 * s)
            };
            let damping = inner_share * inner_share * (self.damping.chi * elastic + ramp(inner))
                + outer_share * outer_share * (self.damping.chi * outer_elastic + ramp(outer));
            let swing = 2.0 * orbit * across_velocity - orbit * orbit * along;
            // a_e'/a_e² times a_e: finite at touch.
            let bend = inner_share
                * (inner_share * k_i * per_stiffness * k_i * per_stiffness * 0.5
                    - outer_share * outer_share * outer_share * 0.5 / (outer + 1e-30));
            l.inertia.0[k] = mass * (outer_share * outer_share * swing + bend * rate * rate);
            l.normal.0[k] = elastic + rate * damping;
        }
    }

    /// Loads of eight balls, and slip over both contacts as base + height · per_height.
    #[inline(always)]
    fn slips(&self, drive: &Drive, active: &Lane, balls: &Balls, border: &Border, l: &mut Locals) {
        let m = &self.mechanism;
        let mass = m.ball_mass;
        let [svy, svz] = border.spindle_velocity;
        for k in 0..WIDTH {
            let normal = l.normal.0[k] + l.inertia.0[k] - l.outer_share.0[k] * l.pocket_radial.0[k];
            let presses = (normal > 0.0) & (l.outer_share.0[k] > 0.0);
            let normal = if presses { normal } else { 0.0 };
            let outer = normal + l.body.0[k] + l.pocket_radial.0[k];
            l.inner_load.0[k] = normal;
            l.outer_load.0[k] = positive(outer) * active.0[k];
            let share = if presses { l.outer_share.0[k] } else { 0.0 };
            l.mass.0[k] = mass * share * share;
            // Slip of both contacts: base + height · per_height.
            let tangential = l.radius.0[k] * l.orbit.0[k];
            let spin = m.spin_ratio * drive.speed + balls.spin.0[k];
            let lean = l.lean.0[k];
            let across = lean * (l.radius.0[k] - l.along.0[k]);
            let radius = l.radius.0[k] - l.along.0[k] + 0.5 * across * lean;
            let along_velocity = svy * l.cosine.0[k] + svz * l.sine.0[k];
            let relative = tangential * (1.0 - 0.5 * lean * lean) - l.across_velocity.0[k]
                + lean * (l.radial_velocity.0[k] - along_velocity);
            l.inner_slip.base.0[k] = drive.speed * radius - relative;
            l.inner_slip.per_height.0[k] = spin - drive.speed;
            l.outer_slip.base.0[k] = -tangential;
            l.outer_slip.per_height.0[k] = -spin;
            l.inner_square.0[k] = self.axis_square.inner * l.inner.0[k];
            l.outer_square.0[k] = self.axis_square.outer * l.outer.0[k];
        }
    }

    /// Rates of eight balls, and their force on the spindle.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn ball_rates(
        &self,
        drive: &Drive,
        active: &Lane,
        balls: &Balls,
        inner: &Sums,
        outer: &Sums,
        rates: &mut BallRates,
        l: &mut Locals,
    ) {
        let m = &self.mechanism;
        let per_mass = 1.0 / m.ball_mass;
        let weight = m.ball_mass * m.gravity;
        let per_inertia = 1.0 / m.ball_inertia;
        for k in 0..WIDTH {
            let (q_i, q_e) = (l.inner_load.0[k], l.outer_load.0[k]);
            let (t_i, t_e) = (q_i * inner.force.0[k], q_e * outer.force.0[k]);
            let drag = drive.mixture.drag[0] + drive.mixture.drag[1] * balls.arc_velocity.0[k];
            let churning = drive.mixture.churning[0] + drive.mixture.churning[1] * balls.spin.0[k];
            let force = t_i + t_e - l.lean.0[k] * q_i + l.pocket_across.0[k] + drag - weight * l.sine.0[k];
            let turning = (force * per_mass - 2.0 * l.radial_velocity.0[k] * l.orbit.0[k]) / l.radius.0[k];
            rates.arc_velocity.0[k] = active.0[k] * m.pitch_radius * (turning - m.orbit_ratio * drive.acceleration);
            let moment = q_e * outer.moment.0[k] - q_i * inner.moment.0[k] + l.pocket_moment.0[k] + churning;
            rates.spin.0[k] = active.0[k] * (moment * per_inertia - m.spin_ratio * drive.acceleration);
            let (s_i, s_e) = (q_i * inner.slope.0[k], q_e * outer.slope.0[k]);
            let cross = (s_i - s_e) * self.ball_radius;
            rates.matrix[0].0[k] = (s_i + s_e + l.pocket_damping.0[k]) * per_mass;
            rates.matrix[1].0[k] = cross * per_mass;
            rates.matrix[2].0[k] = cross * per_inertia;
            rates.matrix[3].0[k] = (s_i + s_e) * self.ball_radius * self.ball_radius * per_inertia;
            // On the spindle, along and across; then in Y and Z.
            let along = -(q_i + l.lean.0[k] * t_i);
            let across = l.lean.0[k] * q_i - t_i;
            let (c, s) = (l.cosine.0[k], l.sine.0[k]);
            l.spindle_y.0[k] = along * c - across * s;
            l.spindle_z.0[k] = along * s + across * c;
            l.mass_yy.0[k] = l.mass.0[k] * c * c;
            l.mass_yz.0[k] = l.mass.0[k] * c * s;
            l.mass_zz.0[k] = l.mass.0[k] * s * s;
        }
    }

    /// Forces of the pockets on eight balls, along and across the orbit, and on the cage.
    #[inline(always)]
    fn pockets(&self, border: &Border, balls: &Balls, drive: &Drive, active: &Lane, l: &mut Locals) {
        let m = &self.mechanism;
        let cage_spin = m.orbit_ratio * drive.speed + border.cage_velocity[2] / m.pitch_radius;
        let mut offset: [Lane; 4] = Default::default();
        self.film(border, cage_spin, active, l, &mut offset);
        let mut solid = !self.plain_pocket;
        for k in 0..WIDTH {
            solid |= l.distance.0[k] * active.0[k] > self.film.clearance;
        }
        if solid {
            self.solid_pockets(&offset, balls, drive, cage_spin, active, l);
        }
        self.pocket_forces(l);
    }

    /// Films of eight pockets; `offset`: displacement and relative velocity in the pocket's own directions.
    #[inline(always)]
    fn film(&self, border: &Border, cage_spin: f64, active: &Lane, l: &mut Locals, offset: &mut [Lane; 4]) {
        let m = &self.mechanism;
        let ([cy, cz], [vy, vz, _]) = (border.cage, border.cage_velocity);
        for k in 0..WIDTH {
            // In the pocket's own directions: n outwards, t along the orbit.
            let (nc, ns) = (l.pocket_cosine.0[k], l.pocket_sine.0[k]);
            let (dc, ds) = (l.ahead_cosine.0[k], l.ahead_sine.0[k]);
            let (r, radial) = (l.radius.0[k], l.radial_velocity.0[k]);
            let tangential = r * l.orbit.0[k];
            let d_n = r * dc - m.pitch_radius - (cy * nc + cz * ns);
            let d_t = r * ds - (cz * nc - cy * ns);
            let v_n = radial * dc - tangential * ds - (vy * nc + vz * ns) + cage_spin * d_t;
            let v_t = radial * ds + tangential * dc - (vz * nc - vy * ns) - cage_spin * (m.pitch_radius + d_n);
            offset[0].0[k] = d_n;
            offset[1].0[k] = d_t;
            offset[2].0[k] = v_n;
            offset[3].0[k] = v_t;
            let square = d_n * d_n + d_t * d_t + 1e-60;
            let distance = square.sqrt();
            let inverse = 1.0 / distance;
            let rate = (d_n * v_n + d_t * v_t) * inverse;
            let onset = 1.0 - positive(1.0 - distance * (1.0 / DAMPING_ONSET));
            let damping = self.film.damping * onset;
            let load = self.film.stiffness * distance + damping * rate;
            let damping = if load > 0.0 { damping * active.0[k] } else { 0.0 };
            let load = positive(load);
            let (n, t) = (d_n * inverse, d_t * inverse);
            let force = load * active.0[k];
            l.pocket_load.0[k] = force;
            l.pocket_n.0[k] = -force * n;
            l.pocket_t.0[k] = -force * t;
            l.pocket_moment.0[k] = 0.0;
            l.cage_moment.0[k] = -((m.pitch_radius + d_n) * l.pocket_t.0[k] - d_t * l.pocket_n.0[k]);
            l.distance.0[k] = distance;
            let (y, z) = (n * nc - t * ns, n * ns + t * nc);
            l.pocket_damping.0[k] = damping * t * t;
            l.cage_damping[0].0[k] = damping * y * y;
            l.cage_damping[1].0[k] = damping * z * z;
            l.cage_damping[2].0[k] = damping * t * t;
        }
    }

    /// Forces of eight pockets, turned to the orbits of the balls and to Y and Z.
    #[inline(always)]
    fn pocket_forces(&self, l: &mut Locals) {
        for k in 0..WIDTH {
            let (n, t) = (l.pocket_n.0[k], l.pocket_t.0[k]);
            let (dc, ds) = (l.ahead_cosine.0[k], l.ahead_sine.0[k]);
            l.pocket_radial.0[k] = n * dc + t * ds;
            l.pocket_across.0[k] = t * dc - n * ds;
            let (nc, ns) = (l.pocket_cosine.0[k], l.pocket_sine.0[k]);
            l.cage[0].0[k] = -(n * nc - t * ns);
            l.cage[1].0[k] = -(n * ns + t * nc);
            l.cage[2].0[k] = l.cage_moment.0[k];
        }
    }

    /// Pockets whose balls touch the wall, or all with hydrodynamic terms: by the pocket of the full model.
    #[inline(never)]
    fn solid_pockets(
        &self,
        [d_n, d_t, v_n, v_t]: &[Lane; 4],
        balls: &Balls,
        drive: &Drive,
        cage_spin: f64,
        active: &Lane,
        l: &mut Locals,
    ) {
        let m = &self.mechanism;
        for k in 0..WIDTH {
            if active.0[k] == 0.0 || (self.plain_pocket && l.distance.0[k] <= self.film.clearance) {
                continue;
            }
            let spin = m.spin_ratio * drive.speed + balls.spin.0[k] - cage_spin;
            let motion = PocketMotion {
                displacement: [0.0, d_n.0[k], d_t.0[k]],
                velocity: [0.0, v_n.0[k], v_t.0[k]],
                spin: [spin, 0.0, 0.0],
            };
            let load = m.pocket.load(&motion);
            let (n, t) = (load.force[1], load.force[2]);
            l.pocket_load.0[k] = load.normal;
            (l.pocket_n.0[k], l.pocket_t.0[k]) = (n, t);
            l.pocket_moment.0[k] = load.moment[0];
            l.cage_moment.0[k] = -((m.pitch_radius + d_n.0[k] + load.lever[1]) * t - (d_t.0[k] + load.lever[2]) * n);
        }
    }

    #[inline(always)]
    fn traction(&self, inner: bool, l: &Locals, drive: &Drive, balls: &Balls) -> Sums {
        let (law, slip, square, load) = if inner {
            (&self.traction.inner, &l.inner_slip, &l.inner_square, &l.inner_load)
        } else {
            (&self.traction.outer, &l.outer_slip, &l.outer_square, &l.outer_load)
        };
        match law {
            RacewayTraction::Rising(law) => law.sums(slip, square, load),
            RacewayTraction::General => self.general_traction(inner, l, drive, balls),
        }
    }

    #[inline(never)]
    fn general_traction(&self, inner: bool, l: &Locals, drive: &Drive, balls: &Balls) -> Sums {
        let m = &self.mechanism;
        let mut sums = Sums::default();
        for k in 0..WIDTH {
            let load = if inner { l.inner_load.0[k] } else { l.outer_load.0[k] };
            if load <= 0.0 {
                continue;
            }
            let spin = m.spin_ratio * drive.speed + balls.spin.0[k];
            // The contact of the full model measures its own penetration from the radius.
            let (contact, slip, penetration, speed, towards) = if inner {
                (&m.raceway.inner, &l.inner_slip, l.inner.0[k], drive.speed, -1.0)
            } else {
                (&m.raceway.outer, &l.outer_slip, l.outer.0[k], 0.0, 1.0)
            };
            let radius = m.pitch_radius + towards * (0.5 * self.clearance + penetration);
            let motion = RelativeMotion {
                axial: 0.0,
                radius,
                velocity: [0.0, 0.0, speed * radius - slip.base.0[k]],
                spin: [spin, 0.0, 0.0],
                raceway_speed: speed,
                orbit_speed: l.orbit.0[k],
                azimuth: 0.0,
            };
            let [force, moment, slope, seen] =
                general_sums(contact, &motion, towards, load, self.damping.chi, self.ball_radius);
            sums.force.0[k] = force;
            sums.moment.0[k] = moment;
            sums.slope.0[k] = slope;
            sums.slip.0[k] = seen;
        }
        sums
    }
}

/// What drives the motion at a time.
#[derive(Clone, Copy)]
struct Drive {
    angle: f64,
    speed: f64,
    acceleration: f64,
    /// The cage's azimuth.
    ideal: Azimuth,
    mixture: Mixture,
    root: f64,
}

/// Forces of all balls on spindle (y, z) and cage (y, z, moment), mass that moves with the spindle (yy, yz, zz), damping of the cage.
#[derive(Clone, Copy, Default)]
struct BorderSums {
    force: [f64; 2],
    mass: [f64; 3],
    cage: [f64; 3],
    damping: [f64; 3],
}

/// Room for an evaluation, and what was seen in it.
#[derive(Debug, Clone)]
pub struct Scratch {
    pub seen: Vec<Seen>,
    locals: Box<Locals>,
    turn: Turn,
}

/// An azimuth on its way: turned on by small angles, anew after some of them.
#[derive(Debug, Clone)]
struct Turn {
    angle: f64,
    azimuth: Azimuth,
    left: u32,
}

impl Turn {
    const SMALL: f64 = 0.05;
    const ANEW: u32 = 64;

    #[inline(always)]
    fn to(&mut self, angle: f64) -> Azimuth {
        let x = angle - self.angle;
        self.angle = angle;
        if self.left == 0 || x.abs() > Self::SMALL {
            self.left = Self::ANEW;
            self.azimuth = Azimuth::new(angle);
        } else {
            self.left -= 1;
            let x2 = x * x;
            let cosine = 1.0 - x2 * (0.5 - x2 * (1.0 / 24.0 - x2 * (1.0 / 720.0 - x2 * (1.0 / 40_320.0))));
            let sine = x * (1.0 - x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5_040.0))));
            self.azimuth = self.azimuth.turned(Azimuth { cosine, sine });
        }
        self.azimuth
    }
}

impl Scratch {
    pub fn new(model: &RadiallyCondensed) -> Self {
        Self {
            seen: vec![Seen::default(); model.groups],
            locals: Box::default(),
            turn: Turn { angle: 0.0, azimuth: Azimuth::new(0.0), left: 0 },
        }
    }
}

/// Quantities of eight balls on their way through an evaluation.
#[derive(Debug, Clone, Copy, Default)]
struct Locals {
    ahead_cosine: Lane,
    ahead_sine: Lane,
    pocket_cosine: Lane,
    pocket_sine: Lane,
    cosine: Lane,
    sine: Lane,
    orbit: Lane,
    body: Lane,
    lean: Lane,
    along: Lane,
    across_velocity: Lane,
    inner: Lane,
    outer: Lane,
    outer_share: Lane,
    radial_velocity: Lane,
    radius: Lane,
    normal: Lane,
    inertia: Lane,
    mass: Lane,
    distance: Lane,
    pocket_load: Lane,
    pocket_n: Lane,
    pocket_t: Lane,
    pocket_radial: Lane,
    pocket_across: Lane,
    pocket_moment: Lane,
    pocket_damping: Lane,
    cage_moment: Lane,
    cage: [Lane; 3],
    cage_damping: [Lane; 3],
    inner_load: Lane,
    outer_load: Lane,
    inner_slip: Slip,
    outer_slip: Slip,
    inner_square: Lane,
    outer_square: Lane,
    spindle_y: Lane,
    spindle_z: Lane,
    mass_yy: Lane,
    mass_yz: Lane,
    mass_zz: Lane,
}

#[inline(never)]
fn turned(arc: &Lane, per_radius: f64, sine: &mut Lane, cosine: &mut Lane) {
    for k in 0..WIDTH {
        (sine.0[k], cosine.0[k]) = (arc.0[k] * per_radius).sin_cos();
    }
}

/// The larger of a number and 0, by arithmetic: a comparison here becomes a branch that keeps balls from going side by side.
#[inline(always)]
fn positive(x: f64) -> f64 {
    0.5 * (x + x.abs())
}

/// Sum over the balls, always in the same order.
#[inline(always)]
fn total(lane: &Lane) -> f64 {
    let [a, b, c, d, e, f, g, h] = lane.0;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}
