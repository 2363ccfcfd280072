//! Pockets of several balls: the film in a short form, walls and hydrodynamic terms by the pocket of the full model.

use super::ball::{Held, Pushed};
use super::border::Border;
use crate::numerics::lanes::{InstructionSet, LANES, Lanes, SideBySide, Singles, Task, larger, side_by_side, smaller};
use crate::physics::pocket::{DAMPING_ONSET, Pocket, PocketLoad, PocketMotion};

/// Stands in for no displacement at all where its direction is asked for [m²].
const TINY: f32 = 1e-30;

/// The film of the pockets of a cage, and how the cage moves.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Film<T = f32> {
    /// [N/m], [N s/m], [m]
    pub stiffness: T,
    pub damping: T,
    pub clearance: T,
    pub pitch_radius: T,
}
side_by_side!(Film { stiffness, damping, clearance, pitch_radius });

/// Of a ball in its pocket: n outwards, t along the orbit.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Displaced<T = f32> {
    displacement: (T, T),
    velocity: (T, T),
    distance: T,
}
side_by_side!(Displaced { displacement, velocity, distance });

/// Force on the ball (n, t) [N].
#[derive(Debug, Clone, Copy)]
pub(super) struct Push {
    load: f32,
    force: (f32, f32),
    moment: f32,
    /// From the pocket's centre to where the cage is pushed.
    lever: (f32, f32),
    damping: f32,
    /// Force over distance [N/m].
    held: f32,
    /// 1/distance², for the direction of the damping.
    per_square: f32,
}

impl Film {
    #[inline(always)]
    pub fn displaced_one(&self, border: &Border<f32>, cage_spin: f32, held: &Held) -> Displaced {
        let ([cy, cz], [vy, vz, _]) = (border.cage, border.cage_velocity);
        let (nc, ns) = (held.pocket.cosine, held.pocket.sine);
        let (dc, ds) = (held.ahead.cosine, held.ahead.sine);
        // Differences of what is nearly the same are taken beforehand: 1 − cos, radius less pitch radius, orbit speed less the cage's.
        let versine = 0.5 * ds * ds * (1.0 + 0.25 * ds * ds);
        let (cage_n, cage_t) = (cy * nc + cz * ns, cz * nc - cy * ns);
        let past = held.radius * held.past_cage;
        let n = held.lift - held.radius * versine - cage_n;
        let t = held.radius * ds - cage_t;
        let v_n = held.radial_velocity * dc - past * ds - (vy * nc + vz * ns) - cage_spin * cage_t;
        let v_t = held.radial_velocity * ds + past * dc - (vz * nc - vy * ns) + cage_spin * cage_n;
        Displaced { displacement: (n, t), velocity: (v_n, v_t), distance: (n * n + t * t).sqrt() }
    }

    /// The force of the film: stiffness and damping along the displacement, not below 0.
    #[inline(always)]
    pub fn push(&self, displaced: &Displaced) -> Push {
        let ((n, t), (v_n, v_t)) = (displaced.displacement, displaced.velocity);
        let per_square = 1.0 / (n * n + t * t + TINY);
        let damping = self.damping * smaller(displaced.distance * (1.0 / DAMPING_ONSET as f32), 1.0);
        let over_distance = larger(self.stiffness + damping * ((n * v_n + t * v_t) * per_square), 0.0);
        Push {
            load: over_distance * displaced.distance,
            force: (-over_distance * n, -over_distance * t),
            moment: 0.0,
            lever: (0.0, 0.0),
            damping: if over_distance > 0.0 { damping } else { 0.0 },
            held: over_distance,
            per_square,
        }
    }

    /// Turned to the ball's own orbit and, with `present`, to the cage; `share`: of velocities in places [s].
    #[inline(always)]
    pub fn turned(&self, held: &Held, displaced: &Displaced, push: &Push, present: f32, share: f32) -> Pushed {
        let ((n, t), (d_n, d_t)) = (push.force, displaced.displacement);
        let (dc, ds) = (held.ahead.cosine, held.ahead.sine);
        let (nc, ns) = (held.pocket.cosine, held.pocket.sine);
        let square = push.damping * push.per_square;
        let (d_y, d_z) = (d_n * nc - d_t * ns, d_n * ns + d_t * nc);
        let (n_present, t_present) = (present * n, present * t);
        let (arm_n, arm_t) = (self.pitch_radius + d_n + push.lever.0, d_t + push.lever.1);
        // What holds a place holds the velocity in it.
        let by_place = share * push.held;
        let damping = square * d_t * d_t + by_place;
        Pushed {
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

    /// How far a ball is beyond the wall of its pocket [m].
    #[inline(always)]
    pub fn beyond(&self, displaced: &Displaced) -> f32 {
        displaced.distance - self.clearance
    }

    /// Where balls are in their pockets.
    #[inline(always)]
    pub fn displaced(self, border: &Border<f32>, cage_spin: f32, held: &Held<Singles>) -> Displaced<Singles> {
        let mut displaced = Displaced::<Singles>::default();
        for lane in 0..LANES {
            displaced.put(lane, self.displaced_one(border, cage_spin, &held.at(lane)));
        }
        displaced
    }

    /// Whether no ball has come to the wall of its pocket.
    #[inline(always)]
    pub fn reaches(&self, displaced: &Displaced<Singles>) -> bool {
        (0..LANES).all(|lane| self.beyond(&displaced.at(lane)) <= 0.0)
    }

    /// Pockets with nothing but their film.
    #[inline(always)]
    pub fn pushed(
        self,
        held: &Held<Singles>,
        displaced: &Displaced<Singles>,
        present: &Singles,
        share: f32,
    ) -> Pushed<Singles> {
        let mut pushed = Pushed::<Singles>::default();
        for lane in 0..LANES {
            let one = displaced.at(lane);
            pushed.put(lane, self.turned(&held.at(lane), &one, &self.push(&one), present[lane], share));
        }
        pushed
    }

    /// The same by the pockets of the full model.
    #[inline(never)]
    pub fn pushed_by_wall(
        &self,
        by_wall: &ByWall<'_>,
        held: &Held<Singles>,
        present: &Singles,
        share: f32,
    ) -> Pushed<Singles> {
        let load = by_wall.loads();
        let mut pushed = Pushed::<Singles>::default();
        for lane in 0..LANES {
            let (at, load) = (by_wall.displaced.at(lane), load.at(lane));
            let single = |[_, n, t]: [f64; 3]| (n as f32, t as f32);
            let push = Push {
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

/// Pockets of the full model, and how balls move in them; `spins`: of the balls over the cage's.
pub(super) struct ByWall<'a> {
    pub pocket: &'a Pocket,
    pub spins: &'a Singles,
    pub displaced: &'a Displaced<Singles>,
    pub instructions: InstructionSet,
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
            };
            motion.put(lane, one);
        }
        self.instructions.run(PocketLoads { pocket: self.pocket, motion: &motion })
    }
}

/// To be compiled for each instruction set.
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
