//! Limits, defaults and kinds in the schemas of requests. Limits are those of validation, defaults those of a job without the field.

use raceway_core::physics::frame::shaft::USUAL_DAMPING_RATIO;
use serde_json::{Value, json};
use utoipa::openapi::schema::{ArrayItems, Discriminator, Object, ObjectBuilder, OneOfBuilder, Schema, Type};
use utoipa::openapi::{Ref, RefOr};

use super::checked::Job;
use super::kind::{FIELDS_OF_SOME_KINDS, JobKind};
use super::mode_comparison::{DURATION_S, MODE_RANGES, REFERENCE_RANGE};
use crate::contract::json::limits;
use crate::contract::json::schema::{Schemas, change, set_defaults, set_limits};
use crate::contract::json::uploads::Uploads;

/// Name of the schema of a job of any kind.
const JOB: &str = "JobInput";
/// Name of the schema of a rotor job, which shares no scene with the other kinds.
const ROTOR: &str = "RotorJob";
/// Name of the schema of a machine job.
const MACHINE: &str = "MachineJob";
/// Name of the schema of any accuracy job, and of one of a shaft. Both have the same `kind`.
const ACCURACY: &str = "AccuracyJob";
const SHAFT_ACCURACY: &str = "ShaftAccuracyJob";

/// A kind of job in the OpenAPI document.
pub struct Kind {
    pub kind: JobKind,
    /// Name of its schema.
    pub name: &'static str,
    description: &'static str,
    /// Fields of `FIELDS_OF_SOME_KINDS` that it requires.
    requires: &'static [&'static str],
    /// Objects of which it takes fewer fields than a simulation.
    reduced: &'static [&'static Reduced],
    /// Fields whose default is the same for all jobs, and that may be sent with this value. Other defaults follow from other fields, or
    /// exclude them; descriptions state these.
    defaults: &'static [&'static str],
}

/// An object of a job without some of its fields.
struct Reduced {
    field: &'static str,
    /// Name of the schema of the complete object, and of the reduced one.
    of: &'static str,
    name: &'static str,
    without: &'static [&'static str],
}

const METRICS_ALONE: Reduced = Reduced {
    field: "outputs",
    of: "OutputsInput",
    name: "MetricsOutputsInput",
    without: &["spectra", "series", "orders"],
};
const MODEL_ALONE: Reduced = Reduced {
    field: "solver",
    of: "SolverInput",
    name: "ModelInput",
    without: &["method", "relative_tolerance", "fixed_step_us"],
};

pub const KINDS: [Kind; 5] = [
    Kind {
        kind: JobKind::Simulation,
        name: "SimulationJob",
        description: "One run.",
        requires: &[],
        reduced: &[],
        defaults: &[
            "/scene/gravity_m_s2",
            "/scene/operation/radial_load_y_n",
            "/scene/operation/radial_load_z_n",
            "/scene/operation/axial_load_n",
            "/scene/operation/misalignment_mrad/y",
            "/scene/operation/misalignment_mrad/z",
            "/scene/bearing/cage/seat",
            "/scene/bearing/cage/rim_angle_deg",
            "/scene/bearing/cage/friction",
            "/scene/bearing/cage/friction_speed_m_s",
            "/scene/damping/raceway/law",
            "/scene/terms/*",
            "/solver/method",
            "/solver/model_tolerance_db",
            "/outputs/metrics",
            "/outputs/spectra",
            "/outputs/series",
            "/priority",
            "/reuse",
        ],
    },
    Kind {
        kind: JobKind::Study,
        name: "StudyJob",
        description: "A run for each point of a grid.",
        requires: &["axes"],
        reduced: &[&METRICS_ALONE],
        defaults: &["/priority", "/reuse"],
    },
    Kind {
        kind: JobKind::Optimum,
        name: "OptimumJob",
        description: "The point of one or two ranges with the best value of a metric.",
        requires: &["axes", "metric"],
        reduced: &[&METRICS_ALONE],
        defaults: &["/goal", "/priority", "/reuse"],
    },
    Kind {
        kind: JobKind::Uncertainty,
        name: "UncertaintyJob",
        description: "Distribution of metrics from those of inputs, and which input matters most.",
        requires: &["inputs"],
        reduced: &[&METRICS_ALONE],
        defaults: &["/samples", "/design", "/seed", "/metrics", "/priority", "/reuse"],
    },
    Kind {
        kind: JobKind::Accuracy,
        name: "BearingAccuracyJob",
        description: "Error against run time, for several methods and tolerances.",
        requires: &[],
        reduced: &[&METRICS_ALONE, &MODEL_ALONE],
        defaults: &[
            "/methods",
            "/relative_tolerances",
            "/repetitions",
            "/settle_s",
            "/duration_s",
            "/solver/model_tolerance_db",
            "/priority",
        ],
    },
];

/// Adds to the schema of a job the limits of its fields, its kinds, and their defaults.
pub fn complete(schemas: &mut Schemas) {
    // Of schemas that both share, those of a simulation are the wider ones.
    for limits in limits::all_of_rotor() {
        let path: Vec<&str> = limits.pointer().split('/').skip(1).collect();
        for job in [ROTOR, MACHINE, SHAFT_ACCURACY] {
            change(schemas, job, &path, &|number| set_limits(number, limits));
        }
    }
    for (pointer, limits) in limits::all() {
        let path: Vec<&str> = pointer.split('/').skip(1).collect();
        change(schemas, JOB, &path, &|number| set_limits(number, &limits));
    }
    split_shaft_speed(schemas);
    for (job, kind) in [(ROTOR, JobKind::Rotor), (MACHINE, JobKind::Machine), (SHAFT_ACCURACY, JobKind::Accuracy)] {
        change(schemas, job, &[], &|object| drop(object.properties.insert("kind".to_owned(), only(kind).into())));
    }
    for reduced in [METRICS_ALONE, MODEL_ALONE] {
        if let Some(RefOr::T(Schema::Object(whole))) = schemas.get(reduced.of) {
            let mut rest = whole.clone();
            rest.properties.retain(|field, _| !reduced.without.contains(&field.as_str()));
            schemas.insert(reduced.name.to_owned(), RefOr::T(rest.into()));
        }
    }
    let Some(RefOr::T(Schema::Object(every))) = schemas.remove(JOB) else { return };
    schemas.extend(KINDS.iter().map(|kind| (kind.name.to_owned(), RefOr::T(kind.part_of(&every).into()))));
    schemas.insert(JOB.to_owned(), RefOr::T(any_kind(every.description)));
    schemas.insert(ACCURACY.to_owned(), RefOr::T(any_accuracy()));
    for (path, name, value) in rotor_defaults() {
        for job in [ROTOR, MACHINE] {
            change(schemas, job, path, &|object| set_defaults(object, name, Some(&json!({ name: value }))));
        }
    }
    let of_shaft_accuracy = json!({
        "mode_ranges": MODE_RANGES, "reference_range": REFERENCE_RANGE, "duration_s": DURATION_S, "repetitions": 1, "priority": 2,
    });
    change(schemas, SHAFT_ACCURACY, &[], &|object| set_defaults(object, "*", Some(&of_shaft_accuracy)));
    for kind in &KINDS {
        let usual = kind.with_defaults();
        for pointer in kind.defaults {
            let Some((holder, field)) = pointer.rsplit_once('/') else { continue };
            let path: Vec<&str> = holder.split('/').skip(1).collect();
            change(schemas, kind.name, &path, &|object| set_defaults(object, field, usual.pointer(holder)));
        }
    }
}

/// The field `kind` of jobs of one kind.
fn only(kind: JobKind) -> Schema {
    let name = ObjectBuilder::new().schema_type(Type::String).enum_values(Some([kind.name()]));
    name.description(Some("What the job computes.")).into()
}

/// Gives shafts schemas of their speed: they do not turn backwards.
fn split_shaft_speed(schemas: &mut Schemas) {
    const NAMES: [[&str; 2]; 2] = [["SpeedInput", "ShaftSpeedInput"], ["SpeedPointInput", "ShaftSpeedPointInput"]];
    for [of, name] in NAMES {
        if let Some(schema) = schemas.get(of).cloned() {
            schemas.insert(name.to_owned(), schema);
        }
    }
    let [[_, speed], [_, point]] = NAMES;
    if let Some(RefOr::T(Schema::OneOf(of))) = schemas.get_mut(speed) {
        of.description = Some(
            "A constant speed from 0 to 500 000 r/min, or a profile of points with linear interpolation.".to_owned(),
        );
        for item in &mut of.items {
            if let RefOr::T(Schema::Array(points)) = item {
                points.items = ArrayItems::RefOrSchema(Box::new(Ref::from_schema_name(point).into()));
            }
        }
    }
    change(schemas, "RotorOperationInput", &[], &|operation| {
        if let Some(RefOr::Ref(named)) = operation.properties.get_mut("speed_rpm") {
            named.ref_location = Ref::from_schema_name(speed).ref_location;
        }
    });
    for pointer in ["/scene/operation/speed_rpm", "/scene/operation/speed_rpm/rpm"] {
        let path: Vec<&str> = pointer.split('/').skip(1).collect();
        if let Some(limits) = limits::of_rotor_field(pointer) {
            change(schemas, MACHINE, &path, &|number| set_limits(number, limits));
        }
    }
}

/// An accuracy job of one bearing, or of a shaft.
fn any_accuracy() -> Schema {
    let of_bearing = KINDS.iter().filter(|kind| kind.kind == JobKind::Accuracy).map(|kind| kind.name);
    let any = OneOfBuilder::new().description(Some(
        "Error against run time: for several methods and tolerances, or with `scene.shaft` for several numbers of modes.",
    ));
    of_bearing.chain([SHAFT_ACCURACY]).fold(any, |any, name| any.item(Ref::from_schema_name(name))).into()
}

fn any_kind(description: Option<String>) -> Schema {
    let place = |kind: &Kind| Ref::from_schema_name(if kind.kind == JobKind::Accuracy { ACCURACY } else { kind.name });
    let mapping = KINDS.iter().map(|kind| (kind.kind.name(), place(kind).ref_location));
    let [rotor, machine] = [ROTOR, MACHINE].map(|name| move || Ref::from_schema_name(name));
    let of_shafts = [(JobKind::Rotor.name(), rotor().ref_location), (JobKind::Machine.name(), machine().ref_location)];
    let mapping = mapping.chain(of_shafts);
    let any =
        OneOfBuilder::new().description(description).discriminator(Some(Discriminator::with_mapping("kind", mapping)));
    KINDS.iter().fold(any, |any, kind| any.item(place(kind))).item(rotor()).item(machine()).into()
}

/// Fixed defaults of a job with a shaft: path to the object, field and value.
fn rotor_defaults() -> [(&'static [&'static str], &'static str, Value); 16] {
    let (shaft, operation): (&[&str], &[&str]) = (&["scene", "shaft"], &["scene", "operation"]);
    [
        (&[], "modes", json!(8)),
        (&[], "duration_s", json!(0.2)),
        (&[], "mode_range", json!(1.5)),
        (&[], "priority", json!(2)),
        (&[], "reuse", json!(true)),
        (&["scene"], "gravity_m_s2", json!(9.81)),
        (shaft, "damping_ratio", json!(USUAL_DAMPING_RATIO)),
        (shaft, "rotating_share", json!(0)),
        (shaft, "elements", json!("auto")),
        (operation, "radial_load_y_n", json!(0)),
        (operation, "radial_load_z_n", json!(0)),
        (operation, "axial_load_n", json!(0)),
        (&["scene", "shaft", "sections"], "inner_diameter_mm", json!(0)),
        (&["scene", "shaft", "discs"], "transverse_inertia_kg_m2", json!(0)),
        (&["scene", "shaft", "discs"], "axial_inertia_kg_m2", json!(0)),
        (&["scene", "shaft", "unbalances"], "phase_deg", json!(0)),
    ]
}

impl Kind {
    /// The schema of this kind, from that of all fields of all kinds.
    fn part_of(&self, every: &Object) -> Object {
        let mut job = every.clone();
        job.description = Some(self.description.to_owned());
        job.properties.retain(|field, _| {
            let field = &field.as_str();
            !FIELDS_OF_SOME_KINDS.contains(field) || self.kind.takes().contains(field)
        });
        job.required.extend(self.requires.iter().map(|&field| field.to_owned()));
        job.properties.insert("kind".to_owned(), only(self.kind).into());
        for reduced in self.reduced {
            if let Some(RefOr::Ref(part)) = job.properties.get_mut(reduced.field) {
                part.ref_location = Ref::from_schema_name(reduced.name).ref_location;
            }
        }
        job
    }

    /// A job of this kind with all defaults.
    fn with_defaults(&self) -> Value {
        let mut request = json!({
            "kind": self.kind.name(),
            "scene": { "bearing": "article-integrated", "operation": { "speed_rpm": 50000 } },
        });
        if self.kind.takes().contains(&"axes") {
            request["axes"] = json!([{ "path": "/spindle/mass_kg", "from": 0.02, "to": 0.2 }]);
        }
        match self.kind {
            JobKind::Study => request["axes"][0]["count"] = json!(2),
            JobKind::Optimum => request["metric"] = json!("/channels/spindle.y.acceleration/level_db"),
            JobKind::Uncertainty => {
                let distribution = json!({ "type": "uniform", "from": 0.02, "to": 0.2 });
                request["inputs"] = json!([{ "path": "/spindle/mass_kg", "distribution": distribution }]);
            }
            JobKind::Simulation | JobKind::Accuracy | JobKind::Rotor | JobKind::Machine => {}
        }
        let Ok(job) = Job::of(request, &Uploads::default()) else { return Value::Null };
        let mut complete = job.complete();
        complete["priority"] = job.submission().priority.into();
        complete["reuse"] = job.submission().reuse.into();
        if let Job::Optimum(search) = &job {
            complete["goal"] = search.canonical()["goal"].take();
        }
        if let Job::Uncertainty(job) = &job {
            let mut canonical = job.canonical();
            for field in ["samples", "design", "seed", "metrics"] {
                complete[field] = canonical[field].take();
            }
        }
        complete
    }
}
