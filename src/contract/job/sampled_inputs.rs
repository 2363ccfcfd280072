//! The uncertain inputs of a request, and the request that they vary.

use raceway_core::sampling::design::MAX_INPUTS;
use serde_json::{Map, Value};

use super::distribution::{BoreAndLoss, CLEARANCE, Sampled};
use super::many_runs::already_varied;
use super::simulation::Draft;
use super::variation::Variation;
use crate::contract::json::problem::{FieldError, Refusal};

/// The checked inputs of a request.
pub fn inputs(draft: &mut Draft) -> Vec<Sampled> {
    let bearing = bearing_of(draft);
    let (input, defaults) = (&mut draft.input, &mut draft.defaults);
    let given = input.inputs.clone();
    let is_missing = given.is_none();
    let given = given.unwrap_or_default();
    if is_missing {
        defaults.refuse("/inputs", format!("required, but missing: 1 to {MAX_INPUTS} inputs"));
    } else if given.is_empty() || given.len() > MAX_INPUTS {
        defaults.refuse("/inputs", format!("{} inputs: must be from 1 to {MAX_INPUTS}", given.len()));
    }
    let mut inputs: Vec<Sampled> = Vec::new();
    for (number, input) in given.into_iter().take(MAX_INPUTS).enumerate() {
        let pointer = format!("/inputs/{number}");
        let Some(input) = Sampled::of(input.0, &pointer, bearing, defaults) else { continue };
        match inputs.iter().find(|other| other.varied.overlaps(&input.varied)) {
            Some(other) => defaults.refuse(pointer, already_varied(&input.varied, &other.varied)),
            None => inputs.push(input),
        }
    }
    inputs
}

/// Bore and loss of clearance of the scene's bearing; `None` where the scene has errors.
fn bearing_of(draft: &Draft) -> Option<BoreAndLoss> {
    let bore_mm = draft.scene_json()?.pointer("/bearing/inner_diameter_mm")?.as_f64()?;
    let loss = draft.operating_clearance().map(|of| of.shaft_fit_um + of.housing_fit_um + of.temperature_um);
    Some(BoreAndLoss { bore_mm, loss_um: loss.unwrap_or(0.0) })
}

/// The request whose simulations are varied: with the parts of the metrics.
pub fn varied_request(request: &Value, parts: Value, inputs: &[Sampled]) -> Value {
    let mut request = without_replaced(request, inputs);
    if let Value::Object(fields) = &mut request {
        let outputs = fields.entry("outputs").or_insert_with(|| Value::Object(Map::new()));
        if let Value::Object(outputs) = outputs {
            outputs.entry("metrics").or_insert(parts);
        }
    }
    request
}

/// The request without a clearance group where another one is sampled.
pub fn without_replaced(request: &Value, inputs: &[Sampled]) -> Value {
    let mut request = request.clone();
    if inputs.iter().any(|input| input.varied.name == CLEARANCE)
        && let Some(Value::Object(bearing)) = request.pointer_mut("/scene/bearing")
    {
        // Their loss is part of the sampled clearance; without a group they are refused.
        for field in ["radial_clearance_group", "fits", "temperatures"] {
            bearing.remove(field);
        }
    }
    request
}

/// Refuses inputs whose field the scene does not have.
pub fn check_inputs(inputs: &[Sampled], variation: &Variation) -> Result<(), Refusal> {
    let errors = inputs.iter().enumerate().filter_map(|(place, input)| {
        variation.refuses(&input.varied).map(|detail| FieldError::new(format!("/inputs/{place}/path"), detail))
    });
    match errors.collect::<Vec<_>>() {
        errors if errors.is_empty() => Ok(()),
        errors => Err(Refusal::Invalid { errors }),
    }
}
