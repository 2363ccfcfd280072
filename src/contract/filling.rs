//! Fills in defaults and remembers which fields got one.

use super::problem::{FieldError, listed};
use super::{limits, units};
use crate::physics::InvalidParameter;

/// Fields that were left to their default, and what was wrong with the others.
#[derive(Debug, Default)]
pub struct Filling {
    /// Pointers, in the order of filling.
    pub defaults: Vec<String>,
    pub errors: Vec<FieldError>,
    /// Values that do not fit each other.
    together: Vec<FieldError>,
    /// Parts that could not be read, and were left out.
    unread: Vec<FieldError>,
    /// Another bearing stands in the place of the one that is meant.
    has_stand_in: bool,
}

impl Filling {
    /// For a request of which parts could not be read.
    pub fn without(unread: &[FieldError]) -> Self {
        Self { unread: unread.to_vec(), ..Self::default() }
    }

    /// Whether this was given, but could not be read.
    pub fn is_unread(&self, pointer: &str) -> bool {
        self.unread.iter().any(|fault| fault.concerns(pointer))
    }

    /// Notes that another bearing stands in the place of the one that is meant.
    pub fn stand_in(&mut self) {
        self.has_stand_in = true;
    }

    /// The field's value; a field left out gets its default, for good.
    pub fn take<T: Clone>(&mut self, pointer: impl Into<String>, field: &mut Option<T>, default: T) -> T {
        if field.is_none() {
            self.defaults.push(pointer.into());
        }
        field.get_or_insert(default).clone()
    }

    /// The field's value, or the `stand_in` with an error that the field is missing.
    pub fn require<T: Clone>(&mut self, pointer: impl Into<String>, field: &Option<T>, stand_in: T) -> T {
        match field {
            Some(value) => value.clone(),
            None => {
                self.refuse(pointer, "required, but missing");
                stand_in
            }
        }
    }

    pub fn refuse(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.errors.push(FieldError::new(pointer, detail));
    }

    /// What physics builds; `None` after notes of all that it refuses.
    pub fn built<T>(&mut self, result: Result<T, Vec<InvalidParameter>>) -> Option<T> {
        result
            .map_err(|faults| {
                for fault in &faults {
                    let error = units::field_error(fault);
                    match fault {
                        // Said already, and better: a length in metres.
                        InvalidParameter::OutOfRange { .. }
                            if self.errors.iter().any(|other| other.pointer == error.pointer) => {}
                        InvalidParameter::OutOfRange { .. } => self.errors.push(error),
                        InvalidParameter::Inconsistent { .. } => self.together.push(error),
                    }
                }
            })
            .ok()
    }

    /// Refuses a number outside the limits of its field.
    pub fn check(&mut self, pointer: &str, value: f64) {
        let Some(limits) = limits::of_field(pointer) else { return };
        if !(limits.lowest..=limits.highest).contains(&value) {
            self.refuse(pointer, units::out_of_range(value, limits.lowest, limits.highest, false, limits.unit));
        }
    }

    /// Refuses fields of `object` that its `law` does not use: `fields` are (name, is given, is used). Where the law could not be
    /// read, this is another one.
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

    /// The errors worth telling: those of defaults only when nothing else is wrong, since a default
    /// that was computed from a wrong value is wrong as well. What does not fit a value that is not there is not told either.
    pub fn into_result(mut self) -> Result<Vec<String>, Vec<FieldError>> {
        let fits = |error: &FieldError| {
            self.unread.is_empty() && !(self.has_stand_in && error.pointer.starts_with("/scene/bearing/"))
        };
        self.errors.extend(self.together.into_iter().filter(fits));
        if self.errors.is_empty() && self.unread.is_empty() {
            return Ok(self.defaults);
        }
        let (followers, causes): (Vec<_>, Vec<_>) =
            self.errors.into_iter().partition(|error| self.defaults.contains(&error.pointer));
        Err(if causes.is_empty() && self.unread.is_empty() { followers } else { causes })
    }
}
