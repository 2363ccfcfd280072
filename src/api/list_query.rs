//! Filters and pages of a job list.

use serde::Deserialize;
use serde::de::IntoDeserializer;
use serde::de::value::Error as ValueError;
use utoipa::{IntoParams, ToSchema};
use uuid::Uuid;

use super::error::ApiError;
use super::status_name::StatusName;
use crate::contract::JobKind;
use crate::contract::job::kind::JobKindName;
use crate::jobs::{Filter, Status};

/// Selection of the listed jobs. A parameter with several values is repeated, because a label may contain a comma.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(try_from = "Vec<(String, String)>")]
#[into_params(parameter_in = Query)]
pub struct ListQuery {
    /// Only jobs with this status. Repeated (`status=failed&status=cancelled`): any of these.
    #[param(inline = false, required = false, style = Form, explode, max_items = 16)]
    status: Vec<StatusName>,
    /// Only jobs of this kind. Repeated: any of these.
    #[param(inline = false, required = false, style = Form, explode, max_items = 16)]
    kind: Vec<JobKindName>,
    /// Only jobs with this label. Repeated (`label=a&label=b`): all of these.
    #[param(required = false, style = Form, explode, max_items = 16, value_type = Vec<LabelText>, inline)]
    label: Vec<String>,
    /// Only jobs without this label. Repeated: none of these.
    #[param(required = false, style = Form, explode, max_items = 16, value_type = Vec<LabelText>, inline)]
    without_label: Vec<String>,
    /// Largest number of jobs on a page; default 50.
    #[param(minimum = 1, maximum = 200)]
    limit: Option<u32>,
    /// Start of the page, from `next` of the previous page.
    #[param(format = Uuid)]
    cursor: Option<String>,
}

/// Largest number of values of a parameter: a job has no more labels.
const MAX_VALUES: usize = 16;

/// A label in a query; it contains no NUL.
#[derive(ToSchema)]
#[schema(value_type = String, pattern = r"^[^\u0000]*$")]
#[expect(dead_code, reason = "only its schema is used")]
struct LabelText(String);

impl TryFrom<Vec<(String, String)>> for ListQuery {
    type Error = String;

    fn try_from(pairs: Vec<(String, String)>) -> Result<Self, String> {
        let mut query = Self::default();
        for (name, value) in pairs {
            let of = |fault: &dyn std::fmt::Display| format!("{name}: {fault}");
            match &*name {
                "status" => query.status.push(named(&value).map_err(|fault| of(&fault))?),
                "kind" => query.kind.push(named(&value).map_err(|fault| of(&fault))?),
                "label" => query.label.push(value),
                "without_label" => query.without_label.push(value),
                "limit" if query.limit.is_none() => query.limit = Some(value.parse().map_err(|fault| of(&fault))?),
                "cursor" if query.cursor.is_none() => query.cursor = Some(value),
                "limit" | "cursor" => return Err(of(&"must not be repeated")),
                _ => return Err(format!("unknown field `{name}`, expected one of {LIST_PARAMETERS}")),
            }
        }
        let most =
            [query.status.len(), query.kind.len(), query.label.len(), query.without_label.len()].into_iter().max();
        if most > Some(MAX_VALUES) {
            return Err(format!("a parameter takes at most {MAX_VALUES} values"));
        }
        Ok(query)
    }
}

const LIST_PARAMETERS: &str = "`status`, `kind`, `label`, `without_label`, `limit`, `cursor`";

/// The enumeration value with this name.
fn named<'v, T: Deserialize<'v>>(word: &'v str) -> Result<T, ValueError> {
    T::deserialize(word.into_deserializer())
}

impl ListQuery {
    pub fn filter(&self) -> Result<Filter, ApiError> {
        let limit = self.limit.unwrap_or(50);
        if !(1..=200).contains(&limit) {
            return Err(ApiError::BadRequest(format!("query: limit {limit}: must be 1 to 200")));
        }
        let cursor = self.cursor.as_ref().map(|cursor| cursor.parse::<Uuid>()).transpose();
        Ok(Filter {
            statuses: self.status.iter().copied().map(Status::from).collect(),
            kinds: self.kind.iter().map(|kind| JobKind::from(*kind).name().to_owned()).collect(),
            labels: self.label.clone(),
            without_labels: self.without_label.clone(),
            before: cursor.map_err(|_| ApiError::BadRequest("query: cursor: not a cursor of this service".into()))?,
            limit,
        })
    }

    /// The path of the page after a job, with the same filters.
    pub fn page_after(&self, last: Uuid) -> String {
        let mut path = format!("/v1/jobs?limit={}&cursor={last}", self.limit.unwrap_or(50));
        let mut add = |name: &str, value: &str| path.push_str(&format!("&{name}={}", percent_encoded(value)));
        self.status.iter().for_each(|status| add("status", Status::from(*status).name()));
        self.kind.iter().for_each(|kind| add("kind", JobKind::from(*kind).name()));
        self.label.iter().for_each(|label| add("label", label));
        self.without_label.iter().for_each(|label| add("without_label", label));
        path
    }
}

fn percent_encoded(value: &str) -> String {
    let encode = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => char::from(byte).to_string(),
        byte => format!("%{byte:02X}"),
    };
    value.bytes().map(encode).collect()
}
