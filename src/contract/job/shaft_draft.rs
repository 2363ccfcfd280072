//! A request of a job with a shaft, while it is checked.

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::submission::{ServiceFields, Submission, all_errors};
use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::{FieldError, Refusal};
use crate::contract::json::typed::typed_with_errors;
use crate::contract::json::uploads::Uploads;
use crate::contract::scene::housing::PartInput;
use crate::contract::scene::rotor_scene::{ResolvedRotor, RotorSceneInput, refuse_unsupported};
use raceway_core::rotor::restraint::{FreeMotion, Owner, free_motion};

const NOT_RESTRAINED: &str = "they leave a rigid motion of the shaft free: give stiffness in y and z at two places, or tilt stiffness \
                              at one; a shaft with `axial` `free` also needs stiffness in x";

const HINGES_ALONE: &str = "`off` makes hinges of the bearings, which leave a rigid motion of the shaft free: give a second bearing or a support";

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
        if unread.is_empty() && defaults.errors.is_empty() {
            refuse_free_motion(&resolved, input.scene(), &mut defaults);
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

/// Refuses a motion that nothing restrains.
fn refuse_free_motion(resolved: &ResolvedRotor, scene: &RotorSceneInput, defaults: &mut Defaults) {
    const DISPLACEMENTS: [&str; 5] = ["along x", "along y", "along z", "in its tilt about y", "in its tilt about z"];
    match free_motion(&resolved.rotor) {
        None => {}
        Some(FreeMotion::Shaft)
            if resolved.complete.as_ref().is_some_and(|complete| free_motion(complete).is_none()) =>
        {
            defaults.refuse("/scene/terms/tilt", HINGES_ALONE);
        }
        Some(FreeMotion::Shaft) => defaults.refuse("/scene/supports", NOT_RESTRAINED),
        Some(FreeMotion::InsideStructure) => {
            let imported = scene.housing.as_ref().is_some_and(|housing| housing.modes.is_some());
            let pointer = if imported { "/scene/housing/modes" } else { "/scene/housing/matrices/stiffness" };
            defaults.refuse(pointer, "a motion that moves no port has no stiffness: leave it out");
        }
        Some(FreeMotion::Beside(Owner::Part(index), displacement)) => {
            let parts = scene.housing.iter().flat_map(|housing| housing.parts());
            let Some(PartInput { pointer, name, .. }) = parts.into_iter().nth(index) else { return };
            let way = DISPLACEMENTS[displacement];
            let remedy = match displacement {
                0..3 => "give one of its mounts `stiffness_n_per_um` there",
                _ => "give one of its mounts `tilt_n_m_per_mrad`, or two mounts at different places",
            };
            let detail = format!("nothing restrains `{name}` {way}: {remedy}");
            defaults.refuse(pointer, detail);
        }
        Some(FreeMotion::Beside(Owner::OuterRing(index), _)) => {
            let detail = "the shaft and this ring slide together along x: give one bearing another seat, or this one `spring_n_per_um`";
            defaults.refuse(format!("/scene/bearings/{index}/outer_ring"), detail);
        }
    }
}
