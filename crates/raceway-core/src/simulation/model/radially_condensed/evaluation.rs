//! Rates of all balls, of cage and spindle at one time: the formulas of one ball run over eight side by side.

use super::ball::{
    BallInRaceways, BallRates, Balls, Drive, PocketReaction, RacewayLoads, SpindleReaction, small_azimuth,
    spindle_reaction,
};
use super::border::Border;
use super::equations::RadiallyCondensed;
use super::pocket::ByWall;
use super::traction::{General, RacewayTraction, RisingTraction};
use std::f64::consts::PI;

use crate::numerics::angle::sin_cos;
use crate::numerics::lanes::{LANES, Lanes, Real, SideBySide, Singles, Task, larger};
use crate::numerics::ode::adams_moulton::{Defect, Shares};
use crate::physics::bearing::PerRaceway;
use crate::physics::frames::Azimuth;
use crate::physics::spindle::unbalance_force;
use crate::simulation::model::heights::Heights;

/// Rates of the velocities at one time, with their derivatives for the implicit part of a step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rates {
    pub balls: Vec<BallRates<Singles>>,
    /// Load on the spindle, by lane.
    pub(super) passed: SpindleReaction<Singles>,
    /// Rates of the cage's velocities: y, z, along the arc [m/s²].
    pub cage: [f64; 3],
    /// Diagonal of the damping of the cage by its pockets [1/s], not negative.
    pub cage_damping: [f64; 3],
}

/// Shares of rates at the end of a step in the motion there.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StepShares {
    /// Of the spindle's acceleration.
    pub spindle: Shares,
    /// Of the velocities of balls and cage in their places [s].
    pub cage: f64,
}

/// Loads and slip of eight balls in an evaluation.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BallLoads {
    pub load: PerRaceway<Singles>,
    pub slip: PerRaceway<Singles>,
    pub pocket: Singles,
    /// Excess of the orbit radii over the pitch radius [m].
    pub lift: Singles,
}

/// Work space of an evaluation, and the loads of the last one.
#[derive(Debug, Clone)]
pub(crate) struct Scratch {
    pub ball_loads: Vec<BallLoads>,
    cage: Turn,
}

impl Scratch {
    pub(crate) fn new(groups: usize) -> Self {
        Self { ball_loads: vec![BallLoads::default(); groups], cage: Turn::default() }
    }
}

/// Load on the cage (y, z, moment), and its damping.
#[derive(Clone, Copy, Default)]
struct OnCage<T> {
    force: [T; 3],
    damping: [T; 3],
}

/// Result of eight balls in the plain case.
#[derive(Clone, Copy, Default)]
struct Plain {
    rates: BallRates<Singles>,
    passed: SpindleReaction<Singles>,
    on_cage: OnCage<Singles>,
    seen: BallLoads,
}

/// Sums of the loads on spindle and cage over the groups of balls, by lane.
#[derive(Clone, Copy, Default)]
struct AllBalls {
    spindle: SpindleReaction<Singles>,
    cage: OnCage<Singles>,
}

impl RadiallyCondensed {
    /// Rates at a time [s]; `spindle_acceleration`: predicted acceleration; `turned`: ∫ spin dt of the
    /// balls less that of ideal rolling [rad], where they have waves.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn rates(
        &self,
        time: f64,
        balls: &[Balls],
        turned: &[Lanes],
        border: &Border,
        spindle_acceleration: [f64; 2],
        shares: StepShares,
        rates: &mut Rates,
        scratch: &mut Scratch,
    ) -> (f64, f64, f64) {
        if self.is_even {
            self.rates_on::<false>(time, balls, turned, border, spindle_acceleration, shares, rates, scratch)
        } else {
            on_waves(self, time, balls, turned, border, spindle_acceleration, shares, rates, scratch)
        }
    }

    /// `WAVY`: raceways have heights, or balls differ.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn rates_on<const WAVY: bool>(
        &self,
        time: f64,
        balls: &[Balls],
        turned: &[Lanes],
        border: &Border,
        spindle_acceleration: [f64; 2],
        shares: StepShares,
        rates: &mut Rates,
        scratch: &mut Scratch,
    ) -> (f64, f64, f64) {
        let m = &self.mechanism;
        let (turning, (mixture, unloaded_root)) = match self.constant {
            Some((speed, ideal)) => ((speed * time, speed, 0.0), ideal),
            None => {
                let turning = m.rotation.inner.at(time);
                (turning, self.ideal(turning.1))
            }
        };
        let (angle, speed, acceleration) = turning;
        let drive = Drive {
            speed: speed as f32,
            acceleration: acceleration as f32,
            cage: scratch.cage.to(m.orbit_ratio * angle + border.cage_arc * (1.0 / m.pitch_radius)).single(),
            mixture,
            unloaded_root,
            spindle_acceleration: spindle_acceleration.map(|a| a as f32),
            place_share: shares.spindle.place as f32,
            velocity_share: shares.spindle.velocity as f32,
            cage_share: shares.cage as f32,
        };
        let mut sums = AllBalls::default();
        for (group, (balls, rates)) in balls.iter().zip(&mut rates.balls).enumerate() {
            let heights = if WAVY { self.heights(group, angle, balls, border, turned) } else { Heights::default() };
            self.group::<WAVY>(&drive, group, balls, border, &heights, rates, scratch, &mut sums);
        }
        rates.passed = sums.spindle;
        self.cage_rates(turning, border, &sums.cage, rates);
        turning
    }

    /// Heights under eight balls at an angle of the spindle [rad]. Azimuths are those on the rings, about each ring's axis: an inner one turns
    /// with the spindle. Single precision would not tell short waves apart after some turns.
    #[inline(always)]
    fn heights(&self, group: usize, angle: f64, balls: &Balls, border: &Border, turned: &[Lanes]) -> Heights<Singles> {
        let Some(waves) = &self.waves else { return Heights::default() };
        let m = &self.mechanism;
        let start = Lanes::<LANES>::of(&m.start.angle, group * LANES);
        let (orbit, per_radius, [y, z]) = (m.orbit_ratio * angle, 1.0 / m.pitch_radius, border.spindle);
        let (mut azimuth, mut leans) = (PerRaceway::<Lanes>::default(), Lanes::<LANES>::default());
        for lane in 0..LANES {
            let on_outer = start[lane] + orbit + balls.arc[lane] * per_radius;
            let (sine, cosine) = sin_cos(on_outer);
            let lean = (z * cosine - y * sine) / (m.pitch_radius - (y * cosine + z * sine));
            azimuth.put(lane, PerRaceway { inner: on_outer - lean - angle, outer: on_outer });
            leans[lane] = lean;
        }
        let mut heights = waves.at(&azimuth);
        if let Some(turned) = turned.get(group) {
            // A ball turns with its spin in the orbit frame, and its contacts move backwards on it.
            let ideal = (m.spin_ratio - m.orbit_ratio) * angle;
            let mut longitude = PerRaceway::<Lanes>::default();
            for lane in 0..LANES {
                let outer = balls.arc[lane] * per_radius - (ideal + turned[lane]);
                longitude.put(lane, PerRaceway { inner: PI + outer - leans[lane], outer });
            }
            heights.ball = waves.of_balls(group * LANES, &longitude);
        }
        heights.single()
    }

    /// Rates of eight balls, and their loads on spindle and cage. `WAVY`: raceways have `heights`.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn group<const WAVY: bool>(
        &self,
        drive: &Drive,
        group: usize,
        balls: &Balls,
        border: &Border,
        heights: &Heights<Singles>,
        rates: &mut BallRates<Singles>,
        scratch: &mut Scratch,
        sums: &mut AllBalls,
    ) {
        if let (true, RacewayTraction::Rising(inner), RacewayTraction::Rising(outer)) =
            (self.is_plain, &self.traction.inner, &self.traction.outer)
        {
            let laws = PerRaceway { inner: &**inner, outer: &**outer };
            if let Some(found) = self.plain_group::<WAVY>(drive, group, balls, border, heights, laws) {
                *rates = found.rates;
                sums.add(&found.passed, &found.on_cage);
                scratch.ball_loads[group] = found.seen;
                return;
            }
        }
        let cage = self.mechanism.layout.cage;
        // Local copies, which no store in the loops can change.
        let (one, all, start, present) = (self.one, self.all(group), self.start[group], self.present[group]);
        let (drive, balls, cage_arc, border) = (*drive, *balls, border.cage_arc, border.single());
        let (mut ahead, mut held) = (Azimuth::<Singles>::default(), BallInRaceways::<Singles>::default());
        if cage {
            let past = balls.past_pockets(cage_arc);
            for lane in 0..LANES {
                ahead.put(lane, all.ball.at(lane).ahead(past[lane]));
            }
        } else {
            for lane in 0..LANES {
                ahead.put(lane, one.ahead_alone(&balls.at(lane)));
            }
        }
        for lane in 0..LANES {
            let (one, ball) = (all.ball.at(lane), balls.at(lane));
            let height = if WAVY { heights.at(lane) } else { Heights::default() };
            held.put(lane, one.in_raceways::<WAVY>(&drive, start.at(lane), ahead.at(lane), &border, &ball, &height));
        }
        if one.viscous > 0.0 {
            for lane in 0..LANES {
                held.put(lane, one.with_viscous(&held.at(lane)));
            }
        }
        let mut pushed = PocketReaction::<Singles>::default();
        if cage {
            let cage_spin = one.orbit_ratio * drive.speed + border.cage_velocity[2] * one.per_pitch_radius;
            let displaced = self.film.displaced(&border, cage_spin, &held);
            if self.plain_pocket && all.film.reaches(&displaced) {
                pushed = self.film.film_reaction(&held, &displaced, &present, drive.cage_share);
            } else {
                let spins = Lanes(balls.spin.0.map(|spin| one.spin_ratio * drive.speed + spin - cage_spin));
                let pocket = &self.mechanism.pocket;
                let oversize = &all.ball.oversize;
                let instructions = self.instructions;
                let loads = ByWall { pocket, spins: &spins, displaced: &displaced, oversize, instructions };
                pushed = self.film.wall_reaction(&loads, &held, &present, drive.cage_share);
            }
        }
        let mut loaded = RacewayLoads::<Singles>::default();
        for lane in 0..LANES {
            loaded.put(
                lane,
                all.ball.at(lane).raceway_loads::<WAVY>(&drive, &balls.at(lane), &held.at(lane), pushed.radial[lane]),
            );
        }
        let inner = match &self.traction.inner {
            RacewayTraction::Rising(law) => law.sums(&loaded.inner),
            RacewayTraction::Wide(law) => law.sums(&loaded.inner),
            RacewayTraction::General => {
                self.general(&drive, true).sums(&loaded.inner, &balls.spin, &held.inner, &held.orbit)
            }
        };
        let outer = match &self.traction.outer {
            RacewayTraction::Rising(law) => law.sums(&loaded.outer),
            RacewayTraction::Wide(law) => law.sums(&loaded.outer),
            RacewayTraction::General => {
                self.general(&drive, false).sums(&loaded.outer, &balls.spin, &held.outer, &held.orbit)
            }
        };
        let (mut rates_now, mut on_spindle) = (BallRates::<Singles>::default(), SpindleReaction::<Singles>::default());
        for lane in 0..LANES {
            let (held, loaded) = (held.at(lane), loaded.at(lane));
            let mut traction = PerRaceway { inner: inner.at(lane), outer: outer.at(lane) };
            if WAVY {
                traction = all.ball.at(lane).with_lean(&held, &heights.at(lane), &traction);
            }
            rates_now.put(
                lane,
                all.ball.at(lane).rates(&drive, &balls.at(lane), &held, &loaded, &pushed.at(lane), &traction),
            );
            on_spindle.put(lane, spindle_reaction(&held, &loaded, &traction.inner, present[lane]));
        }
        *rates = rates_now;
        sums.add(&on_spindle, &OnCage { force: pushed.cage, damping: pushed.cage_damping });
        scratch.ball_loads[group] = BallLoads {
            load: PerRaceway { inner: loaded.inner.load, outer: loaded.outer.load },
            slip: PerRaceway { inner: inner.slip, outer: outer.slip },
            pocket: pushed.load,
            lift: held.lift,
        };
    }

    /// Rates of eight balls in one pass, where cage and film hold the balls and traction has its short form. `None`: a ball touches the
    /// wall of its pocket, or slips beyond the short form.
    #[inline(always)]
    fn plain_group<const WAVY: bool>(
        &self,
        drive: &Drive,
        group: usize,
        balls: &Balls,
        border: &Border,
        heights: &Heights<Singles>,
        laws: PerRaceway<&RisingTraction>,
    ) -> Option<Plain> {
        let (all, start, present) = (self.all(group), self.start[group], self.present[group]);
        let (drive, balls, cage_arc, border) = (*drive, *balls, border.cage_arc, border.single());
        let cage_spin = self.one.orbit_ratio * drive.speed + border.cage_velocity[2] * self.one.per_pitch_radius;
        let past = balls.past_pockets(cage_arc);
        let mut found = Plain::default();
        let mut beyond = Singles::default();
        for lane in 0..LANES {
            let (ball, one, film) = (balls.at(lane), all.ball.at(lane), all.film.at(lane));
            let height = if WAVY { heights.at(lane) } else { Heights::default() };
            let held = one.in_raceways::<WAVY>(&drive, start.at(lane), one.ahead(past[lane]), &border, &ball, &height);
            let displaced = film.displacement_of_one(&border, cage_spin, &held);
            let pushed = film.turned(&held, &displaced, &film.push(&displaced), present[lane], drive.cage_share);
            let loaded = one.raceway_loads::<WAVY>(&drive, &ball, &held, pushed.radial);
            let (inner, slips) = laws.inner.all.at(lane).fitted(&loaded.inner);
            let (outer, skids) = laws.outer.all.at(lane).fitted(&loaded.outer);
            let mut traction = PerRaceway { inner, outer };
            if WAVY {
                traction = one.with_lean(&held, &height, &traction);
            }
            found.rates.put(lane, one.rates(&drive, &ball, &held, &loaded, &pushed, &traction));
            found.passed.put(lane, spindle_reaction(&held, &loaded, &traction.inner, present[lane]));
            found.on_cage.force.put(lane, pushed.cage);
            found.on_cage.damping.put(lane, pushed.cage_damping);
            found.seen.load.inner[lane] = loaded.inner.load;
            found.seen.load.outer[lane] = loaded.outer.load;
            found.seen.slip.inner[lane] = inner.slip;
            found.seen.slip.outer[lane] = outer.slip;
            found.seen.pocket[lane] = pushed.load;
            found.seen.lift[lane] = held.lift;
            beyond[lane] = larger(film.beyond(&displaced), larger(slips, skids));
        }
        (!beyond.any(|beyond| beyond > 0.0)).then_some(found)
    }

    fn general(&self, drive: &Drive, inner: bool) -> General<'_> {
        let (m, speed) = (&self.mechanism, f64::from(drive.speed));
        let (contact, towards, raceway_speed) =
            if inner { (&m.raceway.inner, -1.0, speed) } else { (&m.raceway.outer, 1.0, 0.0) };
        General {
            contact,
            towards,
            raceway_speed,
            spin: m.spin_ratio * speed,
            touching: m.pitch_radius + towards * 0.5 * f64::from(self.one.clearance),
            chi: self.one.chi.into(),
            instructions: self.instructions,
        }
    }

    /// Equations of the spindle under the loads of balls, applied load, weight and unbalance.
    #[inline(always)]
    pub(super) fn defect(
        &self,
        time: f64,
        (angle, speed, acceleration): (f64, f64, f64),
        [ay, az]: [f64; 2],
        on_spindle: &SpindleReaction<Singles>,
    ) -> Defect {
        let m = &self.mechanism;
        let mut spindle = Defect {
            force: [total(&on_spindle.force.0), total(&on_spindle.force.1)],
            slope: on_spindle.slope.each_ref().map(total),
        };
        spindle.force[0] += m.load[1] + m.spindle_mass * (m.gravity - ay);
        spindle.force[1] += m.load[2] - m.spindle_mass * az;
        spindle.slope[0] += m.spindle_mass;
        spindle.slope[2] += m.spindle_mass;
        if m.unbalance != 0.0 {
            let [_, y, z] = unbalance_force(m.unbalance, angle, speed, acceleration);
            spindle.force = [spindle.force[0] + y, spindle.force[1] + z];
        }
        if let Some([_, y, z, ..]) = m.load_change(time, angle) {
            spindle.force = [spindle.force[0] + y, spindle.force[1] + z];
        }
        spindle
    }

    #[inline(always)]
    fn cage_rates(
        &self,
        (_, speed, acceleration): (f64, f64, f64),
        border: &Border,
        sums: &OnCage<Singles>,
        rates: &mut Rates,
    ) {
        let m = &self.mechanism;
        if !m.layout.cage {
            return;
        }
        let [mut y, mut z, mut moment] = sums.force.each_ref().map(total);
        if let Some(land) = &m.land {
            let spin = m.orbit_ratio * speed + border.cage_velocity[2] / m.pitch_radius;
            let (force, braking) = land.load([0.0, border.cage[0], border.cage[1]], spin, 0.0);
            (y, z, moment) = (y + force[1], z + force[2], moment + braking);
        }
        let (per_mass, arm, per_inertia) = (1.0 / m.cage.mass, m.pitch_radius, 1.0 / m.cage.axial_inertia);
        rates.cage =
            [y * per_mass + m.gravity, z * per_mass, arm * (moment * per_inertia - m.orbit_ratio * acceleration)];
        let [d_y, d_z, d_arc] = sums.damping.each_ref().map(total);
        rates.cage_damping = [d_y * per_mass, d_z * per_mass, d_arc * (arm * arm * per_inertia)];
    }
}

/// Rates on wavy raceways. A call of its own: scenes with ideal circles keep their loop as it is.
#[inline(never)]
#[allow(clippy::too_many_arguments)]
fn on_waves(
    model: &RadiallyCondensed,
    time: f64,
    balls: &[Balls],
    turned: &[Lanes],
    border: &Border,
    spindle_acceleration: [f64; 2],
    shares: StepShares,
    rates: &mut Rates,
    scratch: &mut Scratch,
) -> (f64, f64, f64) {
    model.instructions.run(OnWaves { model, time, balls, turned, border, spindle_acceleration, shares, rates, scratch })
}

/// Rates on wavy raceways, compiled for each instruction set.
struct OnWaves<'a> {
    model: &'a RadiallyCondensed,
    time: f64,
    balls: &'a [Balls],
    turned: &'a [Lanes],
    border: &'a Border,
    spindle_acceleration: [f64; 2],
    shares: StepShares,
    rates: &'a mut Rates,
    scratch: &'a mut Scratch,
}

impl Task for OnWaves<'_> {
    type Answer = (f64, f64, f64);

    #[inline(always)]
    fn run(self) -> Self::Answer {
        let Self { model, time, balls, turned, border, spindle_acceleration, shares, rates, scratch } = self;
        model.rates_on::<true>(time, balls, turned, border, spindle_acceleration, shares, rates, scratch)
    }
}

impl AllBalls {
    #[inline(always)]
    fn add(&mut self, spindle: &SpindleReaction<Singles>, cage: &OnCage<Singles>) {
        for lane in 0..LANES {
            self.spindle.force.0[lane] += spindle.force.0[lane];
            self.spindle.force.1[lane] += spindle.force.1[lane];
            for i in 0..3 {
                self.spindle.slope[i][lane] += spindle.slope[i][lane];
                self.cage.force[i][lane] += cage.force[i][lane];
                self.cage.damping[i][lane] += cage.damping[i][lane];
            }
        }
    }
}

/// Sum over the lanes, always in the same order: pairs of halves, then of quarters, then of eighths.
#[inline(always)]
pub(super) fn total<T: Real + Into<f64>>(lanes: &Lanes<LANES, T>) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes.0;
    let [i, j, k, l] = [a + e, b + f, c + g, d + h];
    let [m, n] = [i + k, j + l];
    (m + n).into()
}

/// A turning azimuth: rotated by small angles, and evaluated exactly after a number of them.
#[derive(Debug, Clone)]
struct Turn {
    angle: f64,
    azimuth: Azimuth,
    left: u32,
}

impl Default for Turn {
    fn default() -> Self {
        Self { angle: 0.0, azimuth: Azimuth::new(0.0), left: 0 }
    }
}

impl Turn {
    /// Largest angle of one rotation [rad].
    const MAX_ANGLE: f64 = 0.05;
    /// Number of rotations between two exact evaluations.
    const MAX_ROTATIONS: u32 = 64;

    #[inline(always)]
    fn to(&mut self, angle: f64) -> Azimuth {
        let by = angle - self.angle;
        self.angle = angle;
        if self.left == 0 || by.abs() > Self::MAX_ANGLE {
            self.left = Self::MAX_ROTATIONS;
            self.azimuth = Azimuth::new(angle);
        } else {
            self.left -= 1;
            self.azimuth = self.azimuth.turned(small_azimuth(by));
        }
        self.azimuth
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::cage::PocketFilm;
    use crate::physics::contact::hertz::series_stiffness;
    use crate::physics::presets;
    use crate::physics::surface::defects::{Defect, Shape};
    use crate::physics::surface::waviness::{RacewaySurface, Surfaces, Wave};
    use crate::simulation::input::scene::Scene;
    use crate::simulation::input::settings::Outputs;

    /// At rest the forces on balls and spindle are the negative gradient of the elastic energy, that of both heights included.
    #[test]
    fn forces_on_surfaces_are_the_gradient_of_the_energy() {
        let preset = presets::article_integrated();
        let mut scene = Scene::of_preset(&preset, 0.0, [0.0, 200.0, 60.0]).unwrap();
        scene.gravity = 0.0;
        scene.cage.film = PocketFilm::None;
        let surface = |order: u32, phase: f64| RacewaySurface {
            waviness: vec![Wave { order, amplitude: 2e-7, phase }],
            ..RacewaySurface::default()
        };
        let mut raceway = PerRaceway { inner: surface(9, 0.7), outer: surface(20, -1.0) };
        // Under the first ball, on the flank of its path.
        let (azimuth, length, depth) = (0.03, 5e-4, 1e-6);
        raceway.outer.defects =
            vec![Defect { azimuth, length, width: None, depth, across: 0.0, shape: Shape::Rectangular }];
        scene.surfaces = Surfaces { raceway, ..Surfaces::default() };
        let model = RadiallyCondensed::new(&scene, &Outputs::vibration()).unwrap();
        let m = &model.mechanism;
        let waves = model.waves.as_ref().unwrap();
        let stiffness = m.raceway.map(|contact| contact.hertz().stiffness);
        let series = series_stiffness(stiffness.inner, stiffness.outer);
        let (nominal, clearance) = (f64::from(model.one.nominal), f64::from(model.one.clearance));
        let heights =
            |angle: f64, lean: f64| waves.at(&PerRaceway { inner: Lanes([angle - lean]), outer: Lanes([angle]) }).at(0);
        let approach = |ball: usize, [y, z]: [f64; 2], arc: f64| {
            let angle = m.start_azimuth(ball) + arc / nominal;
            let (along, across) = (y * angle.cos() + z * angle.sin(), z * angle.cos() - y * angle.sin());
            let lean = across / (nominal - along);
            let raised = heights(angle, lean);
            along - 0.5 * across * lean - clearance + raised.raceway.inner.height + raised.raceway.outer.height
        };
        let energy =
            |ball: usize, spindle: [f64; 2], arc: f64| 0.4 * series * approach(ball, spindle, arc).max(0.0).powf(2.5);
        let (balls, border) = model.start();
        let [y, z] = border.spindle;
        let mut rates = Rates { balls: vec![BallRates::default(); model.groups()], ..Rates::default() };
        let mut scratch = Scratch::new(model.groups());
        let turning = model.rates(0.0, &balls, &[], &border, [0.0; 2], StepShares::default(), &mut rates, &mut scratch);
        let by = 1e-9;
        let mut on_spindle = [m.load[1], m.load[2]];
        let (mut most, mut worst) = (0.0_f64, 0.0_f64);
        for ball in 0..m.layout.balls {
            let at = |spindle: [f64; 2], arc: f64| energy(ball, spindle, arc);
            on_spindle[0] -= (at([y + by, z], 0.0) - at([y - by, z], 0.0)) / (2.0 * by);
            on_spindle[1] -= (at([y, z + by], 0.0) - at([y, z - by], 0.0)) / (2.0 * by);
            let along = -(at([y, z], by) - at([y, z], -by)) / (2.0 * by);
            let found = f64::from(rates.balls[0].arc_velocity[ball]) * m.ball_mass * nominal / m.pitch_radius;
            let load = series * approach(ball, [y, z], 0.0).max(0.0).powf(1.5);
            let raised = heights(m.start_azimuth(ball), 0.0);
            most = most.max(load * (raised.raceway.inner.slope.abs() + raised.raceway.outer.slope.abs()) / nominal);
            worst = worst.max((found - along).abs());
        }
        let found = model.defect(0.0, turning, [0.0; 2], &rates.passed).force;
        let off = [0, 1].map(|axis| (found[axis] - on_spindle[axis]).abs());
        println!("lean up to {most} N; balls off by {worst}, spindle by {off:?}");
        assert!(most > 0.01 && worst < 0.01 * most && off.iter().all(|off| *off < 0.01 * most));
    }
}
