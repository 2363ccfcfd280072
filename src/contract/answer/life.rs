//! Rating life of a bearing, with the numbers that it follows from.

use raceway_core::physics::life::basic::EquivalentLoad;
use raceway_core::physics::life::lubrication::{VISCOSITY_RATIOS, film_ratio};
use raceway_core::physics::rating::table_applies;
use raceway_core::simulation::input::scene::Scene;
use raceway_core::simulation::model::equilibrium::{StaticLoads, static_loads};
use raceway_core::simulation::model::rating_life::{LifeInput, RatingLife, rating_life, reference_hours};
use raceway_core::simulation::result::metrics::Summary;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::job::simulation::Simulation;
use crate::contract::json::numbers::{short, significant};

/// Rating life at 90 % reliability. Static numbers are those of the loads at the start and of the largest speed of the rings relative to each
/// other; loads are those on the spindle, its weight included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LifeAnswer {
    /// Basic rating life of ISO 281 [h]. Absent at rest and without load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub basic_l10h: Option<f64>,
    /// Basic reference rating life of ISO/TS 16281 from the ball loads of the static equilibrium [h]. Absent at rest and where no ball is loaded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub reference_l10h_static: Option<f64>,
    /// The same from the power means of all ball loads of the recorded time, at the mean speed [h]. Only in results with the metrics `life`. Its error
    /// is not estimated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub reference_l10h_dynamic: Option<f64>,
    /// Dynamic equivalent load P of ISO 281 [N]: the radial load up to an axial load of e times it, else X F_r + Y F_a. Absent without load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub equivalent_load_n: Option<f64>,
    /// Viscosity ratio κ = ν/ν₁ [-]. Absent at rest and without oil.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub kappa: Option<f64>,
    /// Reference viscosity ν₁ by the formulas of ISO 281 [mm²/s]. Absent at rest.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub nu1_mm2_s: Option<f64>,
    /// Kinematic viscosity ν at running temperature [mm²/s]: of the oil by its grade, else `viscosity_pa_s` at 900 kg/m³. Absent without oil.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub viscosity_mm2_s: Option<f64>,
    /// Minimum film thickness on the inner raceway over the combined roughness of raceway and ball, Λ [-]: of the most loaded ball at rest, rolling
    /// ideally; in a result with the metrics `contacts`, of its thinnest film. Absent without a film.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub lambda: Option<f64>,
    /// Life factor a_ISO of ISO 281 [-]; a modified life is this times a life above. Absent unless `contamination_factor` and
    /// `bearing.fatigue_load_limit_n` are given and κ is at least 0.1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub a_iso: Option<f64>,
    /// Radial load F_r [N].
    #[schema(minimum = 0)]
    pub radial_load_n: f64,
    /// Axial load F_a that the balls carry, magnitude [N].
    #[schema(minimum = 0)]
    pub axial_load_n: f64,
    /// e of ISO 281 [-]. Absent without load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub e: Option<f64>,
    /// X of ISO 281 [-]. Absent where the radial load alone counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub x: Option<f64>,
    /// Y of ISO 281 [-]. Absent where the radial load alone counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub y: Option<f64>,
    /// Basic dynamic load rating C of the life, given or by ISO 281 [N].
    #[schema(minimum = 0)]
    pub dynamic_load_rating_n: f64,
    /// Basic static load rating C₀, given or by ISO 76 [N].
    #[schema(minimum = 0)]
    pub static_load_rating_n: f64,
    /// Factor f₀ of the static load rating, given or by ISO 76 [-].
    #[schema(minimum = 0)]
    pub f0: f64,
    /// Why a number is absent, and limits of the others.
    #[schema(example = json!(["F_a/F_r = 0.1 does not exceed e = 0.221: the equivalent load is the radial load"]))]
    pub notes: Vec<String>,
}

impl LifeAnswer {
    /// The life of a scene under the loads at rest.
    pub fn of(scene: &Scene, at_rest: &StaticLoads, input: &LifeInput) -> Self {
        let life = rating_life(scene, at_rest, input);
        let RatingLife { ratings, equivalent, .. } = life;
        let counted = equivalent.filter(|of| of.counts_axial).map(|of| of.factors);
        Self {
            basic_l10h: life.basic_hours,
            reference_l10h_static: life.reference_hours,
            reference_l10h_dynamic: None,
            equivalent_load_n: equivalent.map(|of| of.load),
            kappa: life.viscosity_ratio,
            nu1_mm2_s: life.reference_viscosity,
            viscosity_mm2_s: life.viscosity,
            lambda: life.film_ratio,
            a_iso: life.life_factor,
            radial_load_n: life.radial_load,
            axial_load_n: life.axial_load,
            e: equivalent.map(|of| of.factors.limit),
            x: counted.map(|of| of.radial),
            y: counted.map(|of| of.axial),
            dynamic_load_rating_n: ratings.dynamic,
            static_load_rating_n: ratings.statical,
            f0: ratings.static_factor,
            notes: notes(scene, &life, input),
        }
    }

    /// The life with the loads of a run; `None` unless it was asked for.
    pub fn of_run(simulation: &Simulation, summary: &Summary) -> Option<Self> {
        let (scene, input, means) = (simulation.scene(), &simulation.resolved.life, summary.load_means?);
        let at_rest = static_loads(scene, &simulation.terms).ok()?;
        let life = Self::of(scene, &at_rest, input);
        let ratings = rating_life(scene, &at_rest, input).ratings;
        let film = summary.contacts.as_ref().and_then(|contacts| contacts.raceway.inner.min_film_thickness);
        let of_run = film.map(|film_um| film_ratio(1e-6 * film_um, input.raceway_roughness, input.ball_roughness));
        Some(Self {
            reference_l10h_dynamic: reference_hours(scene, &ratings, means, summary.relative_speed),
            lambda: of_run.or(life.lambda),
            ..life
        })
    }
}

/// A number of a note.
fn shown(number: f64) -> String {
    short(significant(number, 3))
}

fn notes(scene: &Scene, life: &RatingLife, input: &LifeInput) -> Vec<String> {
    let mut notes = Vec::new();
    let mut note = |when: bool, text: &dyn Fn() -> String| {
        if when {
            notes.push(text());
        }
    };
    note(life.speed == 0.0, &|| "the rings do not turn against each other: there is no life in hours".to_owned());
    note(life.equivalent.is_none(), &|| {
        "no load acts on the spindle: there is no equivalent load and no basic life".to_owned()
    });
    note(life.speed > 0.0 && life.reference_hours.is_none(), &|| {
        "no ball is loaded at rest: there is no static reference life".to_owned()
    });
    if let Some(EquivalentLoad { load, factors, counts_axial }) = life.equivalent {
        note(!counts_axial && life.axial_load > 0.0, &|| {
            let (ratio, e) = (shown(life.axial_load / life.radial_load), shown(factors.limit));
            format!("F_a/F_r = {ratio} does not exceed e = {e}: the equivalent load is the radial load")
        });
        note(load > 0.5 * life.ratings.dynamic, &|| {
            let (load, rating) = (shown(load), shown(life.ratings.dynamic));
            format!("the equivalent load of {load} N exceeds half of the rating of {rating} N: ISO 281 does not hold")
        });
    }
    note(input.makers.dynamic.is_none() && !table_applies(&scene.bearing), &|| {
        "the grooves are wider than ISO 281 supposes: the rating is too high; give bearing.dynamic_load_rating_n"
            .to_owned()
    });
    note(scene.operation.varying_loads().is_some(), &|| {
        "loads vary: static numbers are those of the loads at the start".to_owned()
    });
    note(!scene.operation.has_constant_speeds(), &|| {
        "speeds vary: static numbers are those of the largest speed".to_owned()
    });
    let is_asked = input.contamination.is_some() || input.fatigue_limit.is_some();
    note(is_asked && life.life_factor.is_none(), &|| {
        let [least, _] = VISCOSITY_RATIOS;
        let ratio = life.viscosity_ratio.map_or("none".to_owned(), shown);
        format!(
            "a_iso needs contamination_factor, bearing.fatigue_load_limit_n, a load and κ of at least {least}; κ is {ratio}"
        )
    });
    notes
}
