//! Names of the parts of a stored result in messages.

pub const REQUEST: &str = "request";
pub const METRICS: &str = "metrics";
pub const VIEWS: &str = "plot data";
pub const REPORT: &str = "report";

/// A signal of a channel.
pub fn signal_name(sort: &str, channel: &str) -> String {
    match sort {
        "series" => format!("series of {channel}"),
        sort => format!("{sort} spectrum of {channel}"),
    }
}

/// A point of a study.
pub fn point_name(number: i64) -> String {
    format!("point {number}")
}
