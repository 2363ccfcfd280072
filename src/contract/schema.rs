//! What the schemas of requests say beyond their types: the limits of each field, from where validation has them; its default, from a
//! job that leaves it out; and which fields a kind of job takes.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use utoipa::Number;
use utoipa::openapi::schema::{
    AllOfBuilder, ArrayItems, Discriminator, Object, ObjectBuilder, OneOfBuilder, Schema, SchemaType, Type,
};
use utoipa::openapi::{Ref, RefOr};

use super::job::{JobKind, job_of};
use super::limits::{self, FieldLimits};

pub type Schemas = BTreeMap<String, RefOr<Schema>>;

/// Name of the schema that stands for every kind of job.
const JOB: &str = "JobInput";

/// Fields that only some kinds of jobs take.
pub const OF_SOME: [&str; 6] = ["axes", "metric", "goal", "methods", "relative_tolerances", "repetitions"];

/// A kind of job in the document.
pub struct Kind {
    pub kind: JobKind,
    /// Name of its schema.
    pub name: &'static str,
    description: &'static str,
    /// Those of `OF_SOME` that it takes.
    pub takes: &'static [&'static str],
    /// Those of them that it requires.
    requires: &'static [&'static str],
    /// Parts of which it takes less than a simulation.
    less: &'static [&'static Less],
    /// Fields with one default whatever else is said, so that it may be said as well. Defaults that follow from other fields, and
    /// those that exclude others once they are said, stand in descriptions alone.
    defaults: &'static [&'static str],
}

/// A part of a job without some of its fields.
struct Less {
    part: &'static str,
    /// Name of the schema of the whole part, and of what is left.
    of: &'static str,
    name: &'static str,
    without: &'static [&'static str],
}

const METRICS_ALONE: Less =
    Less { part: "outputs", of: "OutputsInput", name: "MetricsOutputsInput", without: &["spectra", "series"] };
const MODEL_ALONE: Less = Less {
    part: "solver",
    of: "SolverInput",
    name: "ModelInput",
    without: &["method", "relative_tolerance", "fixed_step_us"],
};

pub const KINDS: [Kind; 4] = [
    Kind {
        kind: JobKind::Simulation,
        name: "SimulationJob",
        description: "One run.",
        takes: &[],
        requires: &[],
        less: &[],
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
            "/scene/lubricant/kind",
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
        takes: &["axes"],
        requires: &["axes"],
        less: &[&METRICS_ALONE],
        defaults: &["/priority", "/reuse"],
    },
    Kind {
        kind: JobKind::Optimum,
        name: "OptimumJob",
        description: "The point of one range or two that is best by a metric.",
        takes: &["axes", "metric", "goal"],
        requires: &["axes", "metric"],
        less: &[&METRICS_ALONE],
        defaults: &["/goal", "/priority", "/reuse"],
    },
    Kind {
        kind: JobKind::Accuracy,
        name: "AccuracyJob",
        description: "Error against run time, by several methods and tolerances.",
        takes: &["methods", "relative_tolerances", "repetitions"],
        requires: &[],
        less: &[&METRICS_ALONE, &MODEL_ALONE],
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
    for (pointer, limits) in limits::all() {
        let way: Vec<&str> = pointer.split('/').skip(1).collect();
        change(schemas, JOB, &way, &|number| limit(number, &limits));
    }
    for less in [METRICS_ALONE, MODEL_ALONE] {
        if let Some(RefOr::T(Schema::Object(whole))) = schemas.get(less.of) {
            let mut left = whole.clone();
            left.properties.retain(|field, _| !less.without.contains(&field.as_str()));
            schemas.insert(less.name.to_owned(), RefOr::T(left.into()));
        }
    }
    let Some(RefOr::T(Schema::Object(every))) = schemas.remove(JOB) else { return };
    schemas.extend(KINDS.iter().map(|kind| (kind.name.to_owned(), RefOr::T(kind.part_of(&every).into()))));
    schemas.insert(JOB.to_owned(), RefOr::T(any_kind(every.description)));
    for kind in &KINDS {
        let usual = kind.usual();
        for pointer in kind.defaults {
            let Some((holder, field)) = pointer.rsplit_once('/') else { continue };
            let way: Vec<&str> = holder.split('/').skip(1).collect();
            change(schemas, kind.name, &way, &|object| set_defaults(object, field, usual.pointer(holder)));
        }
    }
}

fn any_kind(description: Option<String>) -> Schema {
    let place = |kind: &Kind| Ref::from_schema_name(kind.name);
    let mapping = KINDS.iter().map(|kind| (kind.kind.name(), place(kind).ref_location));
    let any =
        OneOfBuilder::new().description(description).discriminator(Some(Discriminator::with_mapping("kind", mapping)));
    KINDS.iter().fold(any, |any, kind| any.item(place(kind))).into()
}

impl Kind {
    /// What this kind takes of all that some kind takes.
    fn part_of(&self, every: &Object) -> Object {
        let mut job = every.clone();
        job.description = Some(self.description.to_owned());
        job.properties.retain(|field, _| !OF_SOME.contains(&field.as_str()) || self.takes.contains(&field.as_str()));
        job.required.extend(self.requires.iter().map(|&field| field.to_owned()));
        let name = ObjectBuilder::new().schema_type(Type::String).enum_values(Some([self.kind.name()]));
        job.properties.insert("kind".to_owned(), name.description(Some("What to do.")).into());
        for less in self.less {
            if let Some(RefOr::Ref(part)) = job.properties.get_mut(less.part) {
                part.ref_location = Ref::from_schema_name(less.name).ref_location;
            }
        }
        job
    }

    /// A job of this kind that leaves out what it may, with every default.
    fn usual(&self) -> Value {
        let mut request = json!({
            "kind": self.kind.name(),
            "scene": { "bearing": "article-integrated", "operation": { "speed_rpm": 50000 } },
        });
        if self.takes.contains(&"axes") {
            request["axes"] = json!([{ "path": "/spindle/mass_kg", "from": 0.02, "to": 0.2 }]);
        }
        match self.kind {
            JobKind::Study => request["axes"][0]["count"] = json!(2),
            JobKind::Optimum => request["metric"] = json!("/channels/spindle.y.acceleration/level_db"),
            JobKind::Simulation | JobKind::Accuracy => {}
        }
        let Ok(job) = job_of(request) else { return Value::Null };
        let mut complete = job.complete();
        complete["priority"] = job.priority.into();
        complete["reuse"] = job.reuse.into();
        if let Some(sought) = &job.sought {
            complete["goal"] = sought.canonical()["goal"].take();
        }
        complete
    }
}

/// Sets the default of a field of an object, or of all (`*`), from those of a whole.
fn set_defaults(object: &mut Object, field: &str, whole: Option<&Value>) {
    for (name, property) in &mut object.properties {
        if field != "*" && field != name {
            continue;
        }
        let Some(value) = whole.and_then(|whole| whole.get(name)).cloned() else { continue };
        match property {
            RefOr::T(Schema::Object(of)) => of.default = Some(value),
            RefOr::T(Schema::Array(of)) => of.default = Some(value),
            RefOr::Ref(named) => {
                // A reference has no place for a default.
                let description = Some(std::mem::take(&mut named.description)).filter(|text| !text.is_empty());
                let of = AllOfBuilder::new().description(description).default(Some(value)).item(named.clone());
                *property = RefOr::T(of.into());
            }
            RefOr::T(_) => {}
        }
    }
}

/// Sets the limits of a number.
fn limit(number: &mut Object, limits: &FieldLimits) {
    if !matches!(number.schema_type, SchemaType::Type(Type::Number | Type::Integer)) {
        return;
    }
    let lowest = Some(in_json(limits.lowest));
    if limits.exclusive {
        number.exclusive_minimum = lowest;
    } else {
        number.minimum = lowest;
    }
    number.maximum = Some(in_json(limits.highest));
}

/// Whole numbers without a fraction, as people write them.
fn in_json(number: f64) -> Number {
    if number.fract() == 0.0 && number.abs() < 1e15 { Number::Int(number as isize) } else { Number::Float(number) }
}

/// Changes what the way through the fields of a named schema leads to.
fn change(schemas: &mut Schemas, name: &str, way: &[&str], change: &impl Fn(&mut Object)) {
    let mut next = vec![(name.to_owned(), way)];
    while let Some((name, way)) = next.pop() {
        if let Some(schema) = schemas.get_mut(&name) {
            follow(schema, way, change, &mut next);
        }
    }
}

/// Follows a way to its end, or to the names of schemas in which it goes on. A list is no step, and of alternatives all are followed.
fn follow<'a>(
    schema: &mut RefOr<Schema>,
    way: &'a [&'a str],
    change: &impl Fn(&mut Object),
    next: &mut Vec<(String, &'a [&'a str])>,
) {
    match schema {
        RefOr::Ref(named) => next.extend(named.ref_location.rsplit('/').next().map(|name| (name.to_owned(), way))),
        RefOr::T(Schema::Object(object)) => match way.split_first() {
            None => change(object),
            Some((field, rest)) => {
                if let Some(property) = object.properties.get_mut(*field) {
                    follow(property, rest, change, next);
                }
            }
        },
        RefOr::T(Schema::OneOf(of)) => of.items.iter_mut().for_each(|item| follow(item, way, change, next)),
        RefOr::T(Schema::AllOf(of)) => of.items.iter_mut().for_each(|item| follow(item, way, change, next)),
        RefOr::T(Schema::Array(array)) => {
            if let ArrayItems::RefOrSchema(items) = &mut array.items {
                follow(items, way, change, next);
            }
        }
        RefOr::T(_) => {}
    }
}
