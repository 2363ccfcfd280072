//! Pockets of several balls: the film in a short form, walls and hydrodynamic terms by the pocket of the full model.

use super::ball::{BallInRaceways, PocketReaction};
use super::border::Border;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Singles, Task, larger, side_by_side, smaller};
use crate::physics::pocket::{DAMPING_ONSET, Pocket, PocketLoad, PocketMotion};

/// Smallest squared displacement [m²], which keeps its direction finite.
const TINY: f32 = 1e-30;

/// Film of the pockets of a cage.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Film<T = f32> {
    /// Stiffness [N/m].
    pub stiffness: T,
    /// Damping [N s/m].
    pub damping: T,
    /// Clearance between ball and wall [m].
    pub clearance: T,
    /// Pitch radius [m].
    pub pitch_radius: T,
}
side_by_side!(Film { stiffness, damping, clearance, pitch_radius });

/// Displacement and velocity of a ball in its pocket: n outwards, t along the orbit.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PocketDisplacement<T = f32> {
    displacement: (T, T),
    velocity: (T, T),
    distance: T,
}
side_by_side!(PocketDisplacement { displacement, velocity, distance });

/// Force of a pocket on its ball (n, t) [N].
#[derive(Debug, Clone, Copy)]
pub(super) struct PocketForce {
    load: f32,
    force: (f32, f32),
    moment: f32,
    /// Lever from the pocket's centre to the point of contact [m].
    lever: (f32, f32),
    damping: f32,
    /// Force over distance [N/m].
    held: f32,
    /// 1/distance², for the direction of the damping.
    per_square: f32,
}

impl Film {
    #[inline(always)]
    pub(crate) fn displacement_of_one(
        &self,
        border: &Border<f32>,
        cage_spin: f32,
        held: &BallInRaceways,
    ) -> PocketDisplacement {
        let ([cy, cz], [vy, vz, _]) = (border.cage, border.cage_velocity);
        let (nc, ns) = (held.pocket.cosine, held.pocket.sine);
        let (dc, ds) = (held.ahead.cosine, held.ahead.sine);
        // Small differences come from closed forms: 1 − cos, radius less pitch radius, orbit speed less the cage's.
        let versine = 0.5 * ds * ds * (1.0 + 0.25 * ds * ds);
        let (cage_n, cage_t) = (cy * nc + cz * ns, cz * nc - cy * ns);
        let past = held.radius * held.past_cage;
        let n = held.lift - held.radius * versine - cage_n;
        let t = held.radius * ds - cage_t;
        let v_n = held.radial_velocity * dc - past * ds - (vy * nc + vz * ns) - cage_spin * cage_t;
        let v_t = held.radial_velocity * ds + past * dc - (vz * nc - vy * ns) + cage_spin * cage_n;
        PocketDisplacement { displacement: (n, t), velocity: (v_n, v_t), distance: (n * n + t * t).sqrt() }
    }

    /// Force of the film: stiffness and damping along the displacement, never attractive.
    #[inline(always)]
    pub(super) fn push(&self, displaced: &PocketDisplacement) -> PocketForce {
        let ((n, t), (v_n, v_t)) = (displaced.displacement, displaced.velocity);
        let per_square = 1.0 / (n * n + t * t + TINY);
        let damping = self.damping * smaller(displaced.distance * (1.0 / DAMPING_ONSET as f32), 1.0);
        let over_distance = larger(self.stiffness + damping * ((n * v_n + t * v_t) * per_square), 0.0);
        PocketForce {
            load: over_distance * displaced.distance,
            force: (-over_distance * n, -over_distance * t),
            moment: 0.0,
            lever: (0.0, 0.0),
            damping: if over_distance > 0.0 { damping } else { 0.0 },
            held: over_distance,
            per_square,
        }
    }

    /// Load in the directions of the ball's orbit and, times `present`, of the cage; `share`: of velocities in places [s].
    #[inline(always)]
    pub(super) fn turned(
        &self,
        held: &BallInRaceways,
        displaced: &PocketDisplacement,
        push: &PocketForce,
        present: f32,
        share: f32,
    ) -> PocketReaction {
        let ((n, t), (d_n, d_t)) = (push.force, displaced.displacement);
        let (dc, ds) = (held.ahead.cosine, held.ahead.sine);
        let (nc, ns) = (held.pocket.cosine, held.pocket.sine);
        let square = push.damping * push.per_square;
        let (d_y, d_z) = (d_n * nc - d_t * ns, d_n * ns + d_t * nc);
        let (n_present, t_present) = (present * n, present * t);
        let (arm_n, arm_t) = (self.pitch_radius + d_n + push.lever.0, d_t + push.lever.1);
        // The stiffness acts on the share of velocities in places as a damping.
        let by_place = share * push.held;
        let damping = square * d_t * d_t + by_place;
        PocketReaction {
            load: push.load,
            radial: n * dc + t * ds,
            along: t * dc - n * ds,
            moment: push.moment,
            damping,
            cage: [
                t_present * ns - n_present * nc,
                -(n_present * ns + t_present * nc),
                arm_t * n_present - arm_n * t_present,
            ],
            cage_damping: [
                present * (square * d_y * d_y + by_place),
                present * (square * d_z * d_z + by_place),
                present * damping,
            ],
        }
    }

    /// Penetration of a ball into the wall of its pocket [m]; negative without contact.
    #[inline(always)]
    pub(super) fn beyond(&self, displaced: &PocketDisplacement) -> f32 {
        displaced.distance - self.clearance
    }

    /// Displacements of balls in their pockets.
    #[inline(always)]
    pub(super) fn displaced(
        self,
        border: &Border<f32>,
        cage_spin: f32,
        held: &BallInRaceways<Singles>,
    ) -> PocketDisplacement<Singles> {
        let mut displaced = PocketDisplacement::<Singles>::default();
        for lane in 0..LANES {
            displaced.put(lane, self.displacement_of_one(border, cage_spin, &held.at(lane)));
        }
        displaced
    }

    /// Loads of pockets whose film alone acts.
    #[inline(always)]
    pub(crate) fn film_reaction(
        self,
        held: &BallInRaceways<Singles>,
        displaced: &PocketDisplacement<Singles>,
        present: &Singles,
        share: f32,
    ) -> PocketReaction<Singles> {
        let mut pushed = PocketReaction::<Singles>::default();
        for lane in 0..LANES {
            let one = displaced.at(lane);
            pushed.put(lane, self.turned(&held.at(lane), &one, &self.push(&one), present[lane], share));
        }
        pushed
    }

    /// Loads by the pockets of the full model.
    #[inline(never)]
    pub(crate) fn wall_reaction(
        &self,
        by_wall: &ByWall<'_>,
        held: &BallInRaceways<Singles>,
        present: &Singles,
        share: f32,
    ) -> PocketReaction<Singles> {
        let load = by_wall.loads();
        let mut pushed = PocketReaction::<Singles>::default();
        for lane in 0..LANES {
            let (at, load) = (by_wall.displaced.at(lane), load.at(lane));
            let single = |[_, n, t]: [f64; 3]| (n as f32, t as f32);
            let push = PocketForce {
                load: load.normal as f32,
                force: single(load.force),
                moment: load.moment[0] as f32,
                lever: single(load.lever),
                ..self.push(&at)
            };
            pushed.put(lane, self.turned(&held.at(lane), &at, &push, present[lane], share));
        }
        pushed
    }
}

/// Pockets of the full model with the motion of their balls; `spins`: of the balls relative to the cage.
pub(super) struct ByWall<'a> {
    pub pocket: &'a Pocket,
    pub spins: &'a Singles,
    pub displaced: &'a PocketDisplacement<Singles>,
    /// Radii of the balls less the nominal one [m].
    pub oversize: &'a Singles,
    pub instructions: InstructionSet,
}

impl Film<Singles> {
    /// Returns whether every ball is off the wall of its pocket.
    #[inline(always)]
    pub(super) fn reaches(&self, displaced: &PocketDisplacement<Singles>) -> bool {
        (0..LANES).all(|lane| self.at(lane).beyond(&displaced.at(lane)) <= 0.0)
    }
}

impl ByWall<'_> {
    fn loads(&self) -> PocketLoad<Lanes> {
        let mut motion = PocketMotion::<Lanes>::default();
        for lane in 0..LANES {
            let at = self.displaced.at(lane);
            let double = |(n, t): (f32, f32)| [0.0, n.into(), t.into()];
            let one = PocketMotion {
                displacement: double(at.displacement),
                velocity: double(at.velocity),
                spin: [self.spins[lane].into(), 0.0, 0.0],
                oversize: self.oversize[lane].into(),
            };
            motion.put(lane, one);
        }
        self.instructions.run(PocketLoads { pocket: self.pocket, motion: &motion })
    }
}

/// Pocket loads, compiled for each instruction set.
struct PocketLoads<'a> {
    pocket: &'a Pocket,
    motion: &'a PocketMotion<Lanes>,
}

impl Task for PocketLoads<'_> {
    type Answer = PocketLoad<Lanes>;

    #[inline(always)]
    fn run(self) -> PocketLoad<Lanes> {
        let mut load = PocketLoad::default();
        self.pocket.loads(self.motion, &mut load);
        load
    }
}
