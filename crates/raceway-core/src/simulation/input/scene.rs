//! The scene: bearing, load, speed and lubricant, checked once on construction.

use std::f64::consts::TAU;

use crate::physics::InvalidParameter;
use crate::physics::bearing::{Bearing, BearingParameters};
use crate::physics::cage::CageParameters;
use crate::physics::contact::damping::DampingLaw;
use crate::physics::defaults::{GRAVITY, RACEWAY_DAMPING};
use crate::physics::kinematics::RingSpeeds;
use crate::physics::limits::Faults;
use crate::physics::loads::LoadDirection;
use crate::physics::lubricant::Lubricant;
use crate::physics::operation::{Operation, SpeedProfile};
use crate::physics::presets::{self, BearingPreset};
use crate::physics::spindle::{AxialHold, Spindle, SpindleTilt, Unbalance};
use crate::physics::surface::waviness::{SurfaceParameters, Surfaces};

/// Choice of the request for one term of the equations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TermChoice {
    /// The scene decides.
    #[default]
    Auto,
    On,
    Off,
}

/// The terms that a scene may switch, by the names used in requests and in `left_out`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Term {
    Gravity,
    Drag,
    Churning,
    Hydrodynamics,
    Cage,
    CageTilt,
    Axial,
    Spin,
    Conformity,
    PocketFilm,
    PocketFriction,
    Unbalance,
    Land,
    FilmThickness,
    BallRadialDynamics,
    BallSpinDynamics,
}

impl Term {
    /// Every term with its name.
    pub const ALL: [(Term, &'static str); 16] = [
        (Term::Gravity, "gravity"),
        (Term::Drag, "drag"),
        (Term::Churning, "churning"),
        (Term::Hydrodynamics, "hydrodynamics"),
        (Term::Cage, "cage"),
        (Term::CageTilt, "cage_tilt"),
        (Term::Axial, "axial"),
        (Term::Spin, "spin"),
        (Term::Conformity, "conformity"),
        (Term::PocketFilm, "pocket_film"),
        (Term::PocketFriction, "pocket_friction"),
        (Term::Unbalance, "unbalance"),
        (Term::Land, "land"),
        (Term::FilmThickness, "film_thickness"),
        (Term::BallRadialDynamics, "ball_radial_dynamics"),
        (Term::BallSpinDynamics, "ball_spin_dynamics"),
    ];

    /// The name in requests and results.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// One choice a term.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Terms {
    choices: [TermChoice; Term::ALL.len()],
}

impl Terms {
    pub fn get(&self, term: Term) -> TermChoice {
        self.choices[term as usize]
    }

    pub fn set(&mut self, term: Term, choice: TermChoice) {
        self.choices[term as usize] = choice;
    }
}

/// Unchecked parameters of a scene, in SI and radians.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneParameters {
    pub bearing: BearingParameters,
    pub cage: CageParameters,
    pub spindle: Spindle,
    pub operation: Operation,
    pub lubricant: Lubricant,
    pub raceway_damping: DampingLaw,
    pub terms: Terms,
    pub surfaces: SurfaceParameters,
    /// Deviations of the pockets, and of the balls' start azimuths, from equal spacing [rad]; empty: equally spaced.
    pub pocket_deviations: Vec<f64>,
    /// Acceleration of gravity along +Y [m/s²].
    pub gravity: f64,
}

/// Checked scene. Later code relies on the checks of [`Scene::new`], for example that a ball fits its groove.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    pub bearing: Bearing,
    pub cage: CageParameters,
    pub spindle: Spindle,
    pub operation: Operation,
    pub lubricant: Lubricant,
    pub raceway_damping: DampingLaw,
    pub terms: Terms,
    pub surfaces: Surfaces,
    /// Deviations of the pockets, and of the balls' start azimuths, from equal spacing [rad]; empty: equally spaced.
    pub pocket_deviations: Vec<f64>,
    pub gravity: f64,
}

impl Scene {
    /// Checks each parameter and their consistency; the error lists every fault.
    pub fn new(p: SceneParameters) -> Result<Self, Vec<InvalidParameter>> {
        let mut faults = Faults::default();
        let bearing = faults.part(Bearing::new(p.bearing));
        p.cage.check(&mut faults);
        p.spindle.check(&mut faults);
        p.operation.check(&mut faults);
        p.lubricant.check(&mut faults);
        p.raceway_damping
            .check(["damping.raceway.restitution", "damping.raceway.at_speed", "damping.raceway.viscous"], &mut faults);
        p.surfaces.check(&mut faults);
        if let Some(bearing) = &bearing {
            p.surfaces.check_fit(bearing, &mut faults);
            check_pockets(&p, bearing, &mut faults);
        }
        faults.check("gravity", p.gravity);
        if p.operation.load[0] != 0.0 && p.spindle.axial != AxialHold::Free {
            let load = p.operation.load[0];
            faults.inconsistent(
                "spindle.axial",
                format!("an axial load of {load} N acts only on a spindle whose axial direction is free"),
            );
        }
        check_directions(&p, &mut faults);
        if p.spindle.tilt != SpindleTilt::Held && p.operation.misalignment != [0.0; 2] {
            faults.inconsistent("spindle.tilt", "a spindle that tilts freely takes no imposed misalignment".to_owned());
        }
        let is_even = p.pocket_deviations.iter().all(|&deviation| deviation == 0.0);
        faults.of(bearing, |bearing| Self {
            surfaces: p.surfaces.of_balls(bearing.parameters.ball_count),
            bearing,
            cage: p.cage,
            spindle: p.spindle,
            operation: p.operation,
            lubricant: p.lubricant,
            raceway_damping: p.raceway_damping,
            terms: p.terms,
            pocket_deviations: if is_even { Vec::new() } else { p.pocket_deviations },
            gravity: p.gravity,
        })
    }

    /// A preset bearing at a constant angular speed [rad/s] under a load along X, Y, Z [N], with default cage, lubricant and damping.
    ///
    /// The spindle is balanced. It is free along X where the load has an axial part.
    pub fn of_preset(preset: &BearingPreset, speed: f64, load: [f64; 3]) -> Result<Self, Vec<InvalidParameter>> {
        let BearingPreset { dimensions, defaults, .. } = preset;
        Self::new(SceneParameters {
            bearing: defaults.parameters(dimensions),
            cage: defaults.cage.parameters(defaults.lubricant),
            spindle: Spindle {
                mass: defaults.spindle_mass,
                unbalance: Unbalance::None,
                axial: if load[0] == 0.0 { AxialHold::Fixed } else { AxialHold::Free },
                tilt: SpindleTilt::Held,
            },
            operation: Operation {
                speed: SpeedProfile::constant(speed)?,
                outer_speed: SpeedProfile::at_rest(),
                load,
                loads: Vec::new(),
                misalignment: [0.0; 2],
                perturbation: None,
            },
            lubricant: presets::lubricant_of(defaults.lubricant).lubricant,
            raceway_damping: RACEWAY_DAMPING,
            terms: Terms::default(),
            surfaces: SurfaceParameters::default(),
            pocket_deviations: Vec::new(),
            gravity: GRAVITY,
        })
    }

    /// Returns true where one ball or pocket differs from another, in size, surface or place.
    pub fn has_unequal_balls(&self) -> bool {
        !self.surfaces.balls.is_empty() || !self.pocket_deviations.is_empty()
    }

    /// Angular speed of the spindle that grades of unbalance refer to: the largest of the profile [rad/s].
    pub fn operating_speed(&self) -> f64 {
        self.operation.speed.largest()
    }

    /// The scene of a run that ends at a time [s]: later points of speeds and loads do not count. A grade of unbalance refers to the whole profile.
    pub(crate) fn until(&self, end: f64) -> Self {
        let mut spindle = self.spindle;
        if let Unbalance::Grade(_) = spindle.unbalance {
            spindle.unbalance = Unbalance::Product(spindle.unbalance_product(self.operating_speed()));
        }
        Self { operation: self.operation.until(end), spindle, ..self.clone() }
    }

    /// Speeds of the rings that films and ideal kinematics refer to: where these roll fastest over each other [rad/s].
    pub fn operating_speeds(&self) -> RingSpeeds {
        self.operation.rotation().operating()
    }
}

/// Refuses loads along or about directions in which the spindle is held.
fn check_directions(p: &SceneParameters, faults: &mut Faults) {
    const DIRECTION: &str = "operation.loads.direction";
    for (place, load) in p.operation.loads.iter().enumerate() {
        match load.direction() {
            Some(LoadDirection::X) if p.spindle.axial != AxialHold::Free => {
                let reason = "a load along X acts only on a spindle whose axial direction is free".to_owned();
                faults.inconsistent_item(DIRECTION, &[place], reason);
            }
            Some(direction) if direction.is_moment() && p.spindle.tilt == SpindleTilt::Held => {
                let reason = "a moment acts only on a spindle whose tilt is free".to_owned();
                faults.inconsistent_item(DIRECTION, &[place], reason);
            }
            _ => {}
        }
    }
}

/// Refuses pockets that leave no cage between them, balls that overlap, and balls that do not fit their pockets.
fn check_pockets(p: &SceneParameters, bearing: &Bearing, faults: &mut Faults) {
    const SPACING: &str = "bearing.cage.pocket_deviations";
    let (deviations, BearingParameters { ball_count, ball_diameter, pitch_diameter, .. }) =
        (&p.pocket_deviations, bearing.parameters);
    let are_inside = deviations.iter().filter(|deviation| !faults.check(SPACING, **deviation)).count() == 0;
    if !deviations.is_empty() && deviations.len() != ball_count {
        faults.inconsistent(SPACING, format!("{} values: the cage has {ball_count} pockets", deviations.len()));
        return;
    }
    if !are_inside {
        return;
    }
    let place = |pocket: usize| deviations.get(pocket).copied().unwrap_or_default();
    let distance = |pocket: usize| {
        let apart = TAU / ball_count as f64 + place((pocket + 1) % ball_count) - place(pocket);
        pitch_diameter * (0.5 * apart).sin()
    };
    let distances: Vec<f64> = (0..ball_count).map(distance).collect();
    let least = ball_diameter + 0.5 * p.cage.pocket_clearance;
    let are_even = deviations.iter().all(|&deviation| deviation == 0.0);
    for (pocket, distance) in distances.iter().enumerate().filter(|(_, distance)| !are_even && **distance < least) {
        let (pocket, next, distance, least) = (pocket + 1, (pocket + 1) % ball_count + 1, 1e3 * distance, 1e3 * least);
        let reason = format!(
            "the centres of pockets {pocket} and {next} are {distance:.4} mm apart: at least {least:.4} mm, a ball and half the clearance"
        );
        faults.inconsistent(SPACING, reason);
    }
    p.surfaces.check_neighbours(&distances, ball_diameter, faults);
    if p.terms.get(Term::Cage) != TermChoice::Off {
        p.surfaces.check_pockets(ball_count, p.cage.pocket_clearance, faults);
    }
}
