//! How the service treats a request of any kind: labels, priority, reuse, time kept.

use serde_json::Value;

use crate::contract::json::defaults::Defaults;
use crate::contract::json::problem::FieldError;

/// A request as it was sent, and how the service treats it.
#[derive(Debug, Clone, PartialEq)]
pub struct Submission {
    pub request: Value,
    pub labels: Vec<String>,
    /// 1 (first) to 4 (last).
    pub priority: u8,
    /// True if the result of an identical finished job may be returned.
    pub reuse: bool,
    /// Time that the job is kept after its end [s].
    pub keep_for_s: Option<f64>,
}

/// Fields of a request that concern only the service.
pub struct ServiceFields<'a> {
    pub labels: &'a Option<Vec<String>>,
    pub priority: &'a mut Option<u32>,
    pub reuse: Option<bool>,
    pub keep_for_s: Option<f64>,
}

impl Submission {
    /// The request with these fields. Errors are noted in `defaults`.
    pub fn of(request: Value, fields: &mut ServiceFields<'_>, defaults: &mut Defaults) -> Self {
        let labels = fields.labels.clone().unwrap_or_default();
        check_labels(&labels, defaults);
        let priority = defaults.fill("/priority", fields.priority, 2);
        defaults.check("/priority", f64::from(priority));
        if let Some(keep) = fields.keep_for_s {
            defaults.check("/keep_for_s", keep);
        }
        Self {
            request,
            labels,
            priority: u8::try_from(priority).unwrap_or(2),
            reuse: fields.reuse.unwrap_or(true),
            keep_for_s: fields.keep_for_s,
        }
    }
}

/// All errors of a request: of fields that could not be read, then of the others, unless an unread field causes them.
pub fn all_errors(unread: Vec<FieldError>, mut errors: Vec<FieldError>) -> Vec<FieldError> {
    errors.retain(|error| !unread.iter().any(|unread| unread.concerns(&error.pointer)));
    errors.splice(0..0, unread);
    errors
}

/// Largest number of labels, and longest label [characters].
const MAX_LABELS: usize = 16;
const MAX_LABEL: usize = 200;

/// Refuses labels that are too many, too long or not printable.
fn check_labels(labels: &[String], defaults: &mut Defaults) {
    if labels.len() > MAX_LABELS {
        defaults.refuse("/labels", format!("{} labels: at most {MAX_LABELS}", labels.len()));
    }
    for (index, label) in labels.iter().enumerate() {
        let length = label.chars().count();
        if length > MAX_LABEL {
            defaults.refuse(format!("/labels/{index}"), format!("{length} characters: at most {MAX_LABEL}"));
        } else if label.chars().any(char::is_control) {
            defaults.refuse(format!("/labels/{index}"), "control characters are not allowed in a label");
        }
    }
}
