//! Torque of friction, split by place, and moments of empirical models beside it.

use raceway_core::physics::bearing::BearingKind;
use raceway_core::physics::friction_reference::{Running, Supply};
use raceway_core::physics::lubricant::LubricantKind;
use raceway_core::simulation::model::equilibrium::{StaticLoads, static_loads};
use raceway_core::simulation::model::rating_life::rating_life;
use raceway_core::simulation::recording::power_balance::RacewayPowers;
use raceway_core::simulation::result::metrics::{FrictionTorque, Summary};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::contract::job::simulation::Simulation;
use crate::contract::json::units::{MM, RPM};
use crate::contract::scene::scene_input::ResolvedScene;

/// Torque of friction about the axis: mean powers of the recorded time over the mean speed of the rings relative to each other. Seals, elastic
/// hysteresis and terms in `left_out` are missing. Its error is not estimated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FrictionAnswer {
    /// Sum of all places [N·mm].
    pub total_n_mm: f64,
    /// Its power [W].
    pub power_loss_w: f64,
    /// On the inner raceway.
    pub inner: RacewayTorqueAnswer,
    /// On the outer raceway.
    pub outer: RacewayTorqueAnswer,
    /// Between balls and pockets of the cage [N·mm].
    pub pockets_n_mm: f64,
    /// Between balls, without a cage [N·mm].
    pub neighbours_n_mm: f64,
    /// On the guiding land of the cage [N·mm].
    pub land_n_mm: f64,
    /// Drag on the orbit of the balls [N·mm].
    pub drag_n_mm: f64,
    /// Churning of the spin of the balls [N·mm].
    pub churning_n_mm: f64,
    /// Supplied by the drives of the rings [N·mm].
    pub drive_n_mm: f64,
    /// Supplied by loads, unbalance and weights [N·mm].
    pub applied_n_mm: f64,
    /// Rise of the kinetic energy of balls, cage and spindle [N·mm].
    pub stored_n_mm: f64,
    /// Torque by which the balance does not close, drive and applied less stored and total [N·mm]: the error of the mean over time.
    pub gap_n_mm: f64,
    /// Moments of empirical models; absent where none applies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub reference: Option<FrictionReferenceAnswer>,
}

/// Torque of one raceway.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct RacewayTorqueAnswer {
    /// Traction: slip, spin and conformity [N·mm].
    pub sliding_n_mm: f64,
    /// Resistance of the film's inlet to rolling [N·mm].
    pub rolling_n_mm: f64,
    /// Damping of the normal loads, and the rise of their elastic energy [N·mm].
    pub normal_n_mm: f64,
}

/// Friction moments of a deep-groove bearing by empirical models, within a factor of about two of usual bearings without seals, at the loads of
/// the start and the largest speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FrictionReferenceAnswer {
    /// Rolling moment of the model of SKF of 2006 [N·mm]; beside `rolling_n_mm` of both raceways. Absent for a bearing without a designation of the
    /// series 60, 62, 63, 64, 68, 69 or 160.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub skf_rolling_n_mm: Option<f64>,
    /// Sliding moment of that model [N·mm]; beside `sliding_n_mm` of both raceways.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 0)]
    pub skf_sliding_n_mm: Option<f64>,
    /// Moment after Palmgren that does not depend on the load, of an oil bath [N·mm].
    #[schema(minimum = 0)]
    pub palmgren_viscous_n_mm: f64,
    /// Least and greatest usual moment after Palmgren that the load adds [N·mm].
    pub palmgren_load_n_mm: [f64; 2],
}

impl FrictionAnswer {
    /// The torque of a run; `None` unless it was asked for, and at rest.
    pub fn of_run(simulation: &Simulation, summary: &Summary) -> Option<Self> {
        let torque = summary.friction.as_ref()?;
        let at_rest = static_loads(simulation.scene(), &simulation.terms).ok();
        let reference = at_rest.and_then(|at_rest| FrictionReferenceAnswer::of(&simulation.resolved, &at_rest));
        Some(Self { reference, ..Self::of(torque) })
    }

    fn of(torque: &FrictionTorque) -> Self {
        let (balance, mean) = (&torque.powers, &torque.powers.mean);
        let n_mm = |power: f64| 1e3 * torque.of(power);
        let raceway = |of: &RacewayPowers| RacewayTorqueAnswer {
            sliding_n_mm: n_mm(of.sliding),
            rolling_n_mm: n_mm(of.rolling),
            normal_n_mm: n_mm(of.normal),
        };
        Self {
            total_n_mm: n_mm(mean.losses()),
            power_loss_w: mean.losses(),
            inner: raceway(&mean.raceway.inner),
            outer: raceway(&mean.raceway.outer),
            pockets_n_mm: n_mm(mean.pockets),
            neighbours_n_mm: n_mm(mean.neighbours),
            land_n_mm: n_mm(mean.land),
            drag_n_mm: n_mm(mean.drag),
            churning_n_mm: n_mm(mean.churning),
            drive_n_mm: n_mm(mean.drive),
            applied_n_mm: n_mm(mean.applied),
            stored_n_mm: n_mm(balance.stored),
            gap_n_mm: n_mm(balance.gap()),
            reference: None,
        }
    }
}

impl FrictionReferenceAnswer {
    /// Moments at the loads of a static equilibrium; `None` for other types, at rest, without oil and without load.
    pub fn of(resolved: &ResolvedScene, at_rest: &StaticLoads) -> Option<Self> {
        let scene = &resolved.scene;
        let life = rating_life(scene, at_rest, &resolved.life);
        let p = &scene.bearing.parameters;
        if p.kind != BearingKind::DeepGroove || life.speed == 0.0 || life.equivalent.is_none() {
            return None;
        }
        let running = Running {
            bore: MM.to_user(p.inner_diameter),
            outside: MM.to_user(p.outer_diameter),
            static_rating: life.ratings.statical,
            radial: life.radial_load,
            axial: life.axial_load,
            speed: RPM.to_user(life.speed),
            viscosity: life.viscosity?,
        };
        let supply = match scene.lubricant.kind {
            LubricantKind::Oil => Supply::OilBath,
            LubricantKind::Grease | LubricantKind::Dry => Supply::Grease,
        };
        let series = resolved.ordered.designation.as_ref().map(|of| of.bearing.series());
        let skf = series.and_then(|series| running.skf(series, supply));
        let palmgren = running.palmgren();
        Some(Self {
            skf_rolling_n_mm: skf.map(|of| of.rolling),
            skf_sliding_n_mm: skf.map(|of| of.sliding),
            palmgren_viscous_n_mm: palmgren.viscous,
            palmgren_load_n_mm: palmgren.of_load,
        })
    }
}
