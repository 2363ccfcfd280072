//! Fills in defaults and remembers which fields got one.

use super::problem::{FieldError, listed};
use crate::physics::InvalidParameter;

use super::units;

/// Fields that were left to their default, and what was wrong with the others.
#[derive(Debug, Default)]
pub struct Filling {
    /// Pointers, in the order of filling.
    pub defaults: Vec<String>,
    pub errors: Vec<FieldError>,
}

impl Filling {
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

    /// Notes what physics refuses.
    pub fn check(&mut self, result: Result<(), InvalidParameter>) {
        if let Err(error) = result {
            self.errors.push(units::field_error(&error));
        }
    }

    /// Refuses a number outside `lowest ..= highest`.
    pub fn within(&mut self, pointer: &str, value: f64, lowest: f64, highest: f64, unit: &str) {
        if !(lowest..=highest).contains(&value) {
            self.refuse(pointer, units::out_of_range(value, lowest, highest, false, unit));
        }
    }

    /// Refuses fields of `object` that its `law` does not use: `fields` are (name, is given, is used).
    pub fn only_used(&mut self, object: &str, law: &str, fields: &[(&str, bool, bool)]) {
        for (name, _, _) in fields.iter().filter(|(_, given, used)| *given && !used) {
            let used = fields.iter().filter(|field| field.2).map(|field| field.0).collect::<Vec<_>>();
            let takes = if used.is_empty() { "no other field".to_owned() } else { listed(used) };
            self.refuse(format!("{object}/{name}"), format!("the law `{law}` takes {takes}"));
        }
    }

    /// The errors worth telling: those of defaults only when nothing else is wrong, since a default
    /// that was computed from a wrong value is wrong as well.
    pub fn into_result(self) -> Result<Vec<String>, Vec<FieldError>> {
        if self.errors.is_empty() {
            return Ok(self.defaults);
        }
        let (followers, causes): (Vec<_>, Vec<_>) =
            self.errors.into_iter().partition(|error| self.defaults.contains(&error.pointer));
        Err(if causes.is_empty() { followers } else { causes })
    }
}
