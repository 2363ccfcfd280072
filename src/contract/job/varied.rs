//! The field or quantity that an axis varies.

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::FieldError;

/// Longest path and longest name among the values [characters]: each row of a table repeats them.
pub const MAX_NAME: usize = 200;
const AXIAL_LOAD_OVER_RATING: &str = "axial_load_over_rating";

/// A varied field of the scene, or a derived quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Varied {
    /// Pointer or quantity, as in the request.
    pub name: String,
    pub target: Target,
}

/// The field that a value sets.
#[derive(Debug, Clone, PartialEq)]
pub enum Target {
    /// A field of the scene, by reference tokens.
    Field(Vec<String>),
    AxialLoadOverRating,
}

impl Varied {
    /// From the path or the quantity of the axis at `pointer` of the request; `None` after an error.
    pub fn of(path: Option<String>, quantity: Option<String>, pointer: &str, defaults: &mut Defaults) -> Option<Self> {
        if let Some(path) = path.as_ref().filter(|path| path.chars().count() > MAX_NAME) {
            let long = path.chars().count();
            defaults.refuse(format!("{pointer}/path"), format!("{long} characters: at most {MAX_NAME}"));
            return None;
        }
        match (path, quantity) {
            (Some(path), None) => match tokens(&path) {
                Some(tokens) => return Some(Self { name: path, target: Target::Field(tokens) }),
                None => defaults.refuse(
                    format!("{pointer}/path"),
                    "must be a JSON pointer into the scene, such as `/spindle/mass_kg`",
                ),
            },
            (None, Some(quantity)) if quantity == AXIAL_LOAD_OVER_RATING => {
                return Some(Self { name: quantity, target: Target::AxialLoadOverRating });
            }
            (None, Some(quantity)) => {
                let quantity: String = quantity.chars().take(100).collect();
                defaults.refuse(
                    format!("{pointer}/quantity"),
                    format!("unknown quantity `{quantity}`; available: `{AXIAL_LOAD_OVER_RATING}`"),
                );
            }
            _ => defaults.refuse(pointer, "takes either `path` or `quantity`"),
        }
        None
    }

    /// Path of fields to the one that is set in the scene.
    fn path(&self) -> Vec<String> {
        match &self.target {
            Target::Field(tokens) => tokens.clone(),
            Target::AxialLoadOverRating => ["operation", "axial_load_n"].map(str::to_owned).to_vec(),
        }
    }

    /// True if both set the same field, or one a part of the other: the second would overwrite the first.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.path().iter().zip(&other.path()).all(|(a, b)| a == b)
    }

    /// True if the field at a pointer into the request is the one that is set, or a part of it.
    pub fn sets(&self, pointer: &str) -> bool {
        let field = pointer.strip_prefix("/scene").and_then(tokens);
        field.is_some_and(|field| field.starts_with(&self.path()))
    }

    /// True if values may be names as well as numbers.
    pub fn takes_names(&self) -> bool {
        self.target != Target::AxialLoadOverRating
    }

    /// Text of an error of the request, for the axis: it names the wrong field by its path into the scene, unless that is the varied
    /// field itself.
    pub fn message(&self, error: &FieldError) -> String {
        let path = error.pointer.strip_prefix("/scene").unwrap_or(&error.pointer);
        if path == self.name { error.detail.clone() } else { format!("`{path}`: {}", error.detail) }
    }
}

/// An error of a simulation with values of these axes, at the axis that set the field: the request need not contain that field.
pub fn at_axis<'a>(error: FieldError, axes: impl Iterator<Item = &'a Varied>) -> FieldError {
    for (place, varied) in axes.enumerate() {
        if varied.sets(&error.pointer) {
            return FieldError::new(format!("/axes/{place}"), varied.message(&error));
        }
    }
    error
}

/// Reference tokens of a pointer to a field; `None` for other texts.
fn tokens(path: &str) -> Option<Vec<String>> {
    let tokens: Vec<String> =
        path.strip_prefix('/')?.split('/').map(|t| t.replace("~1", "/").replace("~0", "~")).collect();
    tokens.iter().all(|token| !token.is_empty()).then_some(tokens)
}
