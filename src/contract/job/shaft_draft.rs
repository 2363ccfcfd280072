//! A request of a job with a shaft, while it is checked.

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::submission::{ServiceFields, Submission, all_errors};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::typed::typed_with_errors;
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::rotor_scene::{ResolvedRotor, RotorSceneInput, refuse_unsupported};

const NOT_RESTRAINED: &str = "they leave a rigid motion of the shaft free: give stiffness in y and z at two places, or tilt stiffness \
                              at one; a shaft with `axial` `free` also needs stiffness in x";

/// A request of a kind that has a shaft.
pub trait ShaftRequest: DeserializeOwned {
    fn scene(&mut self) -> &mut RotorSceneInput;
    fn service(&mut self) -> ServiceFields<'_>;
}

/// A request with its scene in SI.
pub struct ShaftDraft<I> {
    request: Value,
    /// Fields that could not be read.
    unread: Vec<FieldError>,
    pub input: I,
    pub resolved: ResolvedRotor,
    pub defaults: Defaults,
}

impl<I: ShaftRequest> ShaftDraft<I> {
    /// Reads a request and checks its scene.
    pub fn of(request: Value, uploads: &Uploads) -> Result<Self, Refusal> {
        let mut refused = Defaults::default();
        let mut supported = request.clone();
        refuse_unsupported(&mut supported, &mut refused);
        let (input, mut unread) = typed_with_errors::<I>(&supported);
        let Some(mut input) = input else {
            unread.append(&mut refused.errors);
            return Err(Refusal::Invalid { errors: unread });
        };
        let mut defaults = Defaults::without(&unread, uploads);
        defaults.errors.append(&mut refused.errors);
        let resolved = input.scene().resolve(&mut defaults);
        // Whether bearings hold the shaft shows at the operating point.
        let is_checked = unread.is_empty() && defaults.errors.is_empty() && resolved.rotor.bearings.is_empty();
        if is_checked && !resolved.rotor.is_restrained() {
            defaults.refuse("/scene/supports", NOT_RESTRAINED);
        }
        Ok(Self { request, unread, input, resolved, defaults })
    }

    /// The checked request with its scene, or all its errors.
    pub fn finish(mut self) -> Result<(Submission, I, ResolvedRotor), Refusal> {
        let submission = Submission::of(self.request, &mut self.input.service(), &mut self.defaults);
        let errors = all_errors(self.unread, self.defaults.errors);
        if errors.is_empty() { Ok((submission, self.input, self.resolved)) } else { Err(Refusal::Invalid { errors }) }
    }
}
