//! Fills in defaults, remembers which fields got one, and collects the errors of all other fields.

use raceway_core::physics::InvalidParameter;

use super::problem::{FieldError, listed};
use super::uploads::Uploads;
use super::{limits, numbers, parameters};

/// Parts of the scene with lists whose wrong items are left out.
const PARTS_WITH_LISTS: [&str; 2] = ["/scene/surfaces/", "/scene/operation/loads/"];

/// Fields that were left to their default, and the errors found so far.
#[derive(Debug, Default)]
pub struct Defaults {
    /// Pointers to the fields that got their default, in the order of filling.
    pub filled: Vec<String>,
    pub errors: Vec<FieldError>,
    /// Values that are inconsistent with each other.
    inconsistent: Vec<FieldError>,
    /// Parts of the request that could not be read and are missing here.
    unread: Vec<FieldError>,
    /// Series that loads may name.
    pub uploads: Uploads,
    /// True if another bearing replaces the requested one, so that the other fields can still be checked.
    has_substitute: bool,
}

impl Defaults {
    /// For a request that may name these series.
    pub fn with(uploads: &Uploads) -> Self {
        Self { uploads: uploads.clone(), ..Self::default() }
    }

    /// For a request of which some parts could not be read.
    pub fn without(unread: &[FieldError], uploads: &Uploads) -> Self {
        Self { unread: unread.to_vec(), ..Self::with(uploads) }
    }

    /// True if the field was given, but could not be read.
    pub fn is_unread(&self, pointer: &str) -> bool {
        self.unread.iter().any(|error| error.concerns(pointer))
    }

    /// Notes that another bearing replaces the requested one.
    pub fn substitute(&mut self) {
        self.has_substitute = true;
    }

    /// True if another bearing replaces the requested one.
    pub fn is_substituted(&self) -> bool {
        self.has_substitute
    }

    /// The field's value. An empty field gets its default and keeps it.
    pub fn fill<T: Clone>(&mut self, pointer: impl Into<String>, field: &mut Option<T>, default: T) -> T {
        if field.is_none() {
            self.filled.push(pointer.into());
        }
        field.get_or_insert(default).clone()
    }

    /// The field's value, or `substitute` with an error that the field is missing.
    pub fn require<T: Clone>(&mut self, pointer: impl Into<String>, field: &Option<T>, substitute: T) -> T {
        match field {
            Some(value) => value.clone(),
            None => {
                self.refuse(pointer, "required, but missing");
                substitute
            }
        }
    }

    pub fn refuse(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.errors.push(FieldError::new(pointer, detail));
    }

    /// Value of a constructor of `physics`; `None` after its errors were noted.
    pub fn built<T>(&mut self, result: Result<T, Vec<InvalidParameter>>) -> Option<T> {
        result
            .map_err(|errors| {
                for invalid in &errors {
                    let error = parameters::field_error(invalid);
                    match invalid {
                        // The earlier error says more: a length in metres.
                        InvalidParameter::OutOfRange { .. }
                            if self.errors.iter().any(|other| other.pointer == error.pointer) => {}
                        InvalidParameter::OutOfRange { .. } => self.errors.push(error),
                        InvalidParameter::Inconsistent { .. } => self.inconsistent.push(error),
                    }
                }
            })
            .ok()
    }

    /// Refuses a number outside the limits of its field.
    pub fn check(&mut self, pointer: &str, value: f64) {
        if let Some(detail) = self.out_of_limits(pointer, value) {
            self.refuse(pointer, detail);
        }
    }

    /// Reason why a number is outside the limits of its field.
    pub fn out_of_limits(&self, pointer: &str, value: f64) -> Option<String> {
        let limits = limits::of_field(pointer)?;
        let is_inside = (limits.lowest..=limits.highest).contains(&value);
        let detail = || numbers::out_of_range(value, limits.lowest, limits.highest, false, limits.unit);
        (!is_inside).then(detail)
    }

    /// Refuses a number of a rotor job outside the limits of its field; returns whether it is inside.
    pub fn check_of_rotor(&mut self, pointer: &str, value: f64) -> bool {
        let Some(limits) = limits::of_rotor_field(pointer) else { return true };
        let is_inside = (limits.lowest..=limits.highest).contains(&value);
        if !is_inside {
            self.refuse(pointer, numbers::out_of_range(value, limits.lowest, limits.highest, false, limits.unit));
        }
        is_inside
    }

    /// Refuses fields of `object` that its `law` does not use; `fields` are (name, is given, is used). Refuses nothing where the
    /// law itself could not be read: `law` is then a substitute.
    pub fn only_used(&mut self, object: &str, law: &str, fields: &[(&str, bool, bool)]) {
        if self.is_unread(&format!("{object}/law")) {
            return;
        }
        for (name, _, _) in fields.iter().filter(|(_, given, used)| *given && !used) {
            let used = fields.iter().filter(|field| field.2).map(|field| field.0).collect::<Vec<_>>();
            let takes = if used.is_empty() { "no other field".to_owned() } else { listed(used) };
            self.refuse(format!("{object}/{name}"), format!("the law `{law}` takes {takes}"));
        }
    }

    /// The filled fields, or the errors to report. An error of a default is reported only when nothing else is wrong, because a default
    /// that was computed from a wrong value is wrong as well. Inconsistencies are not reported for values that are missing or replaced.
    pub fn into_result(mut self) -> Result<Vec<String>, Vec<FieldError>> {
        // A wrong item is left out of its list, so that the places of later ones differ from those of the request.
        let is_of = |error: &FieldError, part: &str| error.pointer.starts_with(part);
        let wrong: Vec<&str> =
            PARTS_WITH_LISTS.into_iter().filter(|part| self.errors.iter().any(|error| is_of(error, part))).collect();
        let is_requested = |error: &FieldError| {
            self.unread.is_empty()
                && !(self.has_substitute && error.pointer.starts_with("/scene/bearing/"))
                && !wrong.iter().any(|part| is_of(error, part))
        };
        self.errors.extend(self.inconsistent.into_iter().filter(is_requested));
        if self.errors.is_empty() && self.unread.is_empty() {
            return Ok(self.filled);
        }
        let (of_defaults, causes): (Vec<_>, Vec<_>) =
            self.errors.into_iter().partition(|error| self.filled.contains(&error.pointer));
        Err(if causes.is_empty() && self.unread.is_empty() { of_defaults } else { causes })
    }
}
