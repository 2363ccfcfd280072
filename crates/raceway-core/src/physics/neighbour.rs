//! Two neighbouring balls that no cage keeps apart: Hertz contact of equal spheres, dry friction, and the lubricant
//! squeezed out of the gap between them. Vectors are in the inertial frame.

use std::f64::consts::PI;

use super::bearing::Bearing;
use super::cage::CageParameters;
use super::contact::damping::{DampingFactor, normal_load};
use super::contact::hertz::sphere_stiffness;
use super::frames::{Vector, add, cross, dot, length, scale};
use super::lubricant::Lubricant;
use super::material::contact_modulus;
use super::pocket::{DAMPING_END, MIN_SLIP, PocketTerms};
use crate::numerics::exponential::hyperbolic_tangent;
use crate::numerics::lanes::larger;

/// Constants of the contacts between neighbouring balls; all are alike.
#[derive(Debug, Clone, Copy)]
pub struct NeighbourContact {
    ball_diameter: f64,
    stiffness: f64,
    damping: DampingFactor,
    friction: f64,
    friction_speed: f64,
    /// 6π η R², R = d/4: damping of the squeezed film times its thickness [N s]; 0 without a film.
    squeeze: f64,
}

/// Motion of a ball relative to its neighbour.
#[derive(Debug, Clone, Copy, Default)]
pub struct NeighbourMotion {
    /// From the neighbour's centre to the ball's [m].
    pub displacement: Vector,
    /// Velocity of the ball's centre less that of the neighbour's [m/s].
    pub velocity: Vector,
    /// Sum of the angular velocities of both [rad/s].
    pub spin: Vector,
    /// Sum of the radii of both less twice the nominal one [m].
    pub oversize: f64,
}

/// Load of a neighbour on a ball; the neighbour takes the opposite force and the same moment.
#[derive(Debug, Clone, Copy, Default)]
pub struct NeighbourLoad {
    /// Penetration of the solids [m]; negative: the gap between them.
    pub penetration: f64,
    /// Normal load, film and solid [N].
    pub normal: f64,
    /// Force on the ball [N].
    pub force: Vector,
    /// Moment on each of both balls about its centre [N m].
    pub moment: Vector,
}

impl NeighbourContact {
    /// Constants of a bearing. Friction, its speed and the damping of an impact are those of the pockets.
    pub(crate) fn new(bearing: &Bearing, cage: &CageParameters, lubricant: &Lubricant, terms: PocketTerms) -> Self {
        let ball_diameter = bearing.parameters.ball_diameter;
        // 1/R = 2/d + 2/d.
        let relative_radius = 0.25 * ball_diameter;
        let material = &bearing.parameters.ball_material;
        Self {
            ball_diameter,
            stiffness: sphere_stiffness(contact_modulus(material, material), relative_radius),
            damping: cage.damping.resolve(),
            friction: if terms.friction { cage.friction } else { 0.0 },
            friction_speed: cage.friction_speed,
            squeeze: if terms.film { 6.0 * PI * lubricant.viscosity * relative_radius * relative_radius } else { 0.0 },
        }
    }

    /// Load–deflection factor of two balls [N/m^1.5].
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// Force and moment of the neighbour on a ball.
    ///
    /// Solid: Q = K δ^1.5 (1 + χ δ̇). Film: 6π η R² δ̇/(h + h₀) over the gap h (R. G. Cox & H. Brenner 1967 for h ≪ R),
    /// with h₀ = 1 µm, and falling to 0 over the first 1 µm of penetration as in a pocket. It never pulls. It carries no
    /// static load: surfaces of balls that spin alike move against each other, and draw no lubricant into the gap.
    /// Friction acts on the solid part.
    #[inline(always)]
    pub fn load(&self, motion: &NeighbourMotion) -> NeighbourLoad {
        let distance = length(motion.displacement);
        let penetration = self.ball_diameter + motion.oversize - distance;
        if penetration <= 0.0 && self.squeeze == 0.0 {
            return NeighbourLoad { penetration, ..NeighbourLoad::default() };
        }
        let normal = scale(1.0 / distance, motion.displacement);
        let along = dot(motion.velocity, normal);
        let rate = -along;
        let solid = normal_load(self.stiffness, penetration, rate, &self.damping);
        let share = larger(1.0 - larger(penetration, 0.0) * (1.0 / DAMPING_END), 0.0);
        let film = larger(self.squeeze * share * rate / (larger(-penetration, 0.0) + DAMPING_END), 0.0);
        let mut load =
            NeighbourLoad { penetration, normal: solid + film, force: scale(solid + film, normal), moment: [0.0; 3] };
        if self.friction * solid > 0.0 {
            // Both balls touch halfway between their centres, so that their angular momentum is kept.
            let lever = scale(-0.5 * distance, normal);
            let sliding = add(motion.velocity, scale(rate, normal));
            let slip = add(sliding, cross(motion.spin, lever));
            let speed = larger(length(slip), MIN_SLIP);
            let dry = self.friction * solid * hyperbolic_tangent(speed * (1.0 / self.friction_speed)) / speed;
            let force = scale(-dry, slip);
            load.force = add(load.force, force);
            load.moment = cross(lever, force);
        }
        load
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::contact::damping::DampingLaw;
    use crate::physics::examples;

    fn contact(change: impl Fn(&mut CageParameters), film: bool) -> NeighbourContact {
        let mut cage = examples::article_cage();
        change(&mut cage);
        let terms = PocketTerms { film, friction: true, hydrodynamics: false };
        NeighbourContact::new(&examples::article_bearing(), &cage, &examples::article_lubricant(), terms)
    }

    fn at(gap: f64, velocity: Vector, spin: Vector) -> NeighbourMotion {
        NeighbourMotion { displacement: [0.0, 2.778e-3 + gap, 0.0], velocity, spin, oversize: 0.0 }
    }

    /// Balls of 2.778 mm of GCr15 (219 GPa, 0.3): E* = 120.33 GPa, R = 0.6945 mm, K = 4/3 E* √R = 4.228e9 N/m^1.5. Two balls
    /// approach by δ = (9 Q²/(16 E*² R))^(1/3): 1.7752 µm at 10 N.
    #[test]
    fn stiffness_is_that_of_two_spheres() {
        let contact = contact(|cage| cage.damping = DampingLaw::None, false);
        assert!((contact.stiffness() / 4.2281e9 - 1.0).abs() < 1e-4, "{:e}", contact.stiffness());
        let load = contact.load(&at(-1.7752e-6, [0.0; 3], [0.0; 3]));
        assert!((load.force[1] / 10.0 - 1.0).abs() < 1e-3, "{load:?}");
        assert_eq!(contact.load(&at(1e-9, [0.0, -1.0, 0.0], [0.0; 3])).force, [0.0; 3]);
    }

    /// A head-on collision at 0.1 m/s without loss, by the classical Runge–Kutta method: momentum, energy and the exchange of
    /// velocities hold to 1e-8. It lasts T = 2.9432 (5 m*/4 K)^(2/5) v^(−1/5) with m* = m/2 (H. Hertz 1881): 13.01 µs for balls of 87.9 mg.
    #[test]
    fn a_collision_keeps_momentum_and_energy() {
        let contact = contact(|cage| (cage.damping, cage.friction) = (DampingLaw::None, 0.0), false);
        let (mass, speed, step) = (examples::article_bearing().ball_mass, 0.1, 2e-10);
        let force = |y: [f64; 4]| {
            let motion = NeighbourMotion {
                displacement: [0.0, y[0] - y[1], 0.0],
                velocity: [0.0, y[2] - y[3], 0.0],
                spin: [0.0; 3],
                oversize: 0.0,
            };
            contact.load(&motion).force[1]
        };
        let rates = |y: [f64; 4]| [y[2], y[3], force(y) / mass, -force(y) / mass];
        let moved = |y: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
        // The first ball stands; touch at time 0.
        let (mut y, mut time) = ([2.778e-3, 0.0, 0.0, speed], 0.0);
        while time == 0.0 || force(y) > 0.0 {
            let k1 = rates(y);
            let k2 = rates(moved(y, k1, 0.5 * step));
            let k3 = rates(moved(y, k2, 0.5 * step));
            let k4 = rates(moved(y, k3, step));
            y = std::array::from_fn(|i| y[i] + step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
            time += step;
        }
        assert!((y[2] + y[3] - speed).abs() < 1e-8 * speed, "{y:?}");
        assert!((y[2] * y[2] + y[3] * y[3] - speed * speed).abs() < 1e-8 * speed * speed, "{y:?}");
        assert!((y[2] - speed).abs() < 1e-8 * speed, "{y:?}");
        let expected = 2.9432 * (1.25 * 0.5 * mass / contact.stiffness()).powf(0.4) * speed.powf(-0.2);
        assert!((time / expected - 1.0).abs() < 1e-4, "{time:e} {expected:e}");
    }

    /// Friction and impact act on a pair with equal and opposite forces and the same moment about each centre: momentum and
    /// angular momentum are kept, and no power is gained.
    #[test]
    fn friction_keeps_angular_momentum_and_takes_energy() {
        let contact = contact(|_| {}, true);
        let spins = [[300.0, -200.0, 4e3], [-150.0, 900.0, 2e3]];
        let (place, velocity) = ([1e-3, 2.4e-3, -0.95e-3], [0.02, -0.05, 0.03]);
        let motion = NeighbourMotion { displacement: place, velocity, spin: add(spins[0], spins[1]), oversize: 0.0 };
        let load = contact.load(&motion);
        assert!(load.penetration > 0.0 && load.normal > 1.0, "{load:?}");
        // x₁ × F − x₂ × F + 2 M = 0.
        let angular = add(cross(place, load.force), scale(2.0, load.moment));
        assert!(length(angular) < 1e-12 * length(cross(place, load.force)), "{angular:?}");
        let elastic = contact.stiffness * load.penetration.powf(1.5) * dot(velocity, scale(1.0 / length(place), place));
        let power = dot(load.force, velocity) + dot(load.moment, motion.spin);
        assert!(power < elastic, "{power} {elastic}");
    }

    /// Two balls that spin alike rub against each other with twice the speed of their surfaces; both are braked alike.
    #[test]
    fn equal_spins_rub_and_are_braked() {
        let contact = contact(|cage| cage.damping = DampingLaw::None, false);
        let load = contact.load(&at(-1e-6, [0.0; 3], [-2e3, 0.0, 0.0]));
        // Slip 2e3 · 1.389e-3 = 2.8 m/s is far beyond the speed of full friction.
        let friction = 0.08 * load.normal;
        assert!((load.force[2].abs() / friction - 1.0).abs() < 1e-6, "{load:?}");
        assert!((load.moment[0] / (friction * 1.3885e-3) - 1.0).abs() < 1e-6, "{load:?}");
        let rolling = contact.load(&at(-1e-6, [0.0; 3], [0.0; 3]));
        assert_eq!(rolling.moment, [0.0; 3]);
    }

    /// 6π · 0.02 Pa·s · (0.6945 mm)² / (10 µm + 1 µm) = 0.01653 N s/m while balls approach; nothing while they part.
    #[test]
    fn lubricant_is_squeezed_out_of_the_gap() {
        let contact = contact(|_| {}, true);
        let load = contact.load(&at(10e-6, [0.0, -0.1, 0.0], [0.0; 3]));
        assert!((load.force[1] / 1.653e-3 - 1.0).abs() < 1e-3, "{load:?}");
        assert_eq!(contact.load(&at(10e-6, [0.0, 0.1, 0.0], [0.0; 3])).normal, 0.0);
    }
}
