//! `GET /v1/jobs/{id}/metrics`, `spectrum`, `series`, `plots/{file}`.

use serde_json::{Value, json};

use crate::common::{Server, job_with, request};
use crate::server::{InProcess, start};

fn finished(server: &InProcess) -> String {
    let outputs = json!({ "series": ["spindle.y.velocity"] });
    let path = server.submit(&job_with(json!({ "outputs": outputs })));
    server.wait_for(&path, &["succeeded"]);
    path
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("numbers").iter().filter_map(Value::as_f64).collect()
}

#[test]
fn a_spectrum_comes_as_json_and_csv() {
    let server = start();
    let path = finished(&server);
    let whole = server.get(&format!("{path}/spectrum?channel=spindle.y.acceleration")).json();
    for field in ["channel", "unit", "window", "resolution_hz", "mean_step_s", "damped_above_hz"] {
        assert!(!whole[field].is_null(), "{field}");
    }
    let frequencies = numbers(&whole["frequency_hz"]);
    assert_eq!(frequencies.len(), numbers(&whole["amplitude"]).len());
    let low = server.get(&format!("{path}/spectrum?channel=spindle.y.acceleration&max_frequency_hz=3000")).json();
    let expected: Vec<f64> = frequencies.iter().copied().filter(|frequency| *frequency <= 3000.0).collect();
    assert_eq!(numbers(&low["frequency_hz"]), expected);
    let csv = format!("{path}/spectrum?channel=spindle.y.acceleration&max_frequency_hz=3000");
    let csv = request(server.address(), "GET", &csv, &[("Accept", "text/csv")], b"");
    assert_eq!(csv.header("content-type"), Some("text/csv; charset=utf-8"));
    assert_eq!(csv.body.lines().next(), Some("frequency_hz,spindle.y.acceleration [m/s²]"));
    assert_eq!(csv.body.lines().count(), 1 + expected.len());
    let envelope = server.get(&format!("{path}/spectrum?channel=spindle.y.acceleration&kind=envelope")).json();
    assert_eq!(envelope["kind"], "envelope");
}

/// Density, motion and bands of a stored spectrum agree with each other and with the metrics.
#[test]
fn a_spectrum_has_scalings_motions_and_bands() {
    let server = start();
    // 1 ms is recorded, so that bins are 1 kHz apart.
    let path = server.submit(&job_with(json!({ "outputs": { "bands_hz": [3000, 10_000, 20_000] } })));
    server.wait_for(&path, &["succeeded"]);
    let of = |query: &str| server.get(&format!("{path}/spectrum?channel=spindle.y.acceleration{query}")).json();
    let (amplitude, density) = (of(""), of("&scaling=psd"));
    assert_eq!((&density["unit"], &density["scaling"]), (&json!("(m/s²)²/Hz"), &json!("psd")));
    let resolution = amplitude["resolution_hz"].as_f64().unwrap();
    let square: f64 = numbers(&amplitude["amplitude"]).iter().map(|value| value * value / 3.0).sum();
    let sum: f64 = numbers(&density["amplitude"]).iter().map(|value| value * resolution).sum();
    assert!((sum / square - 1.0).abs() < 1e-3, "{sum} {square}");
    let velocity = of("&quantity=velocity");
    assert_eq!(velocity["unit"], "mm/s");
    assert!(numbers(&velocity["frequency_hz"])[0] >= 10.0);
    let bands = server.get(&format!("{path}/bands?edges_hz=3000,10000,20000")).json();
    assert!(bands["bands"].is_array(), "{bands}");
    let metrics = server.get(&format!("{path}/metrics")).json();
    let headline = &metrics["headline"];
    assert_eq!(headline["channel"], "spindle.y.acceleration");
    for (band, stored) in bands["bands"].as_array().unwrap().iter().zip(headline["bands"].as_array().unwrap()) {
        let (one, other) = (&band["velocity_rms_um_s"], &stored["velocity_rms_um_s"]);
        assert!((one.as_f64().unwrap() / other.as_f64().unwrap() - 1.0).abs() < 0.01, "{one} {other}");
    }
    let rms = headline["rms_m_s2"].as_f64().unwrap();
    assert!((headline["rms_g"].as_f64().unwrap() * 9.80665 / rms - 1.0).abs() < 1e-12);
    assert_eq!(headline["levels"][1]["db"], metrics["channels"]["spindle.y.acceleration"]["level_db"]);
}

#[test]
fn a_series_is_cut_and_thinned() {
    let server = start();
    let path = finished(&server);
    let whole = server.get(&format!("{path}/series?channel=spindle.y.velocity")).json();
    let (times, values) = (numbers(&whole["time_s"]), numbers(&whole["value"]));
    assert!(times.len() > 20 && times.len() == values.len());
    let thin = server.get(&format!("{path}/series?channel=spindle.y.velocity&max_points=10")).json();
    assert!(numbers(&thin["value"]).len() <= 10);
    let largest = |values: &[f64]| values.iter().fold(f64::NEG_INFINITY, |a, b| a.max(*b));
    assert_eq!(largest(&numbers(&thin["value"])), largest(&values));
    let (from, to) = (times[3], times[9]);
    let cut = server.get(&format!("{path}/series?channel=spindle.y.velocity&from_s={from}&to_s={to}")).json();
    assert_eq!(numbers(&cut["time_s"]), times[3..=9]);
}

#[test]
fn the_error_for_an_unknown_channel_lists_the_kept_ones() {
    let server = start();
    let path = finished(&server);
    let problem = server.get(&format!("{path}/spectrum?channel=cage.speed")).problem(404);
    let detail = problem["detail"].as_str().expect("a detail");
    assert!(detail.contains("spindle.y.acceleration") && detail.contains("cage.speed"), "{detail}");
    server.get(&format!("{path}/series?channel=cage.speed")).problem(404);
}

#[test]
fn plots_are_drawn() {
    let server = start();
    let path = finished(&server);
    for file in ["spectrum.svg", "velocity.svg", "acceleration.svg", "orbit.svg", "loads.svg"] {
        let plot = server.get(&format!("{path}/plots/{file}"));
        assert_eq!((plot.status, plot.header("content-type")), (200, Some("image/svg+xml")), "{file}");
        assert!(plot.body.starts_with("<svg"), "{file}");
    }
    let no_signals = server.submit(&job_with(json!({ "outputs": { "metrics": ["vibration"], "spectra": [] } })));
    server.wait_for(&no_signals, &["succeeded"]);
    let problem = server.get(&format!("{no_signals}/plots/orbit.svg")).problem(404);
    assert_eq!(problem["type"], "urn:raceway:problem:unknown-plot");
    server.get(&format!("{path}/plots/cat.svg")).problem(404);
    server.get(&format!("{path}/plots/spectrum.png")).problem(404);
}

#[test]
fn every_link_of_a_job_can_be_followed() {
    let server = start();
    let path = finished(&server);
    let other = [json!({ "metrics": ["vibration"] }), json!({ "metrics": ["vibration"], "spectra": [] })]
        .map(|outputs| server.submit(&job_with(json!({ "outputs": outputs }))));
    for path in [&path].into_iter().chain(&other) {
        let job = server.wait_for(path, &["succeeded"]);
        let links = job["links"].as_object().expect("links").iter();
        for (name, link) in links.filter(|(name, _)| *name != "events") {
            assert_eq!(server.get(link.as_str().expect("a path")).status, 200, "{name} of {job}");
        }
    }
    let (spectrum, series) =
        (server.get(&format!("{path}/spectrum")), server.get(&format!("{path}/series?max_points=9")));
    assert_eq!(
        (&spectrum.json()["channel"], &series.json()["channel"]),
        (&json!("spindle.y.acceleration"), &json!("spindle.y.velocity"))
    );
    let none = server.submit(&job_with(json!({ "outputs": { "spectra": [] } })));
    server.wait_for(&none, &["succeeded"]);
    let problem = server.get(&format!("{none}/spectrum")).problem(404);
    assert_eq!(
        (&problem["type"], &problem["detail"]),
        (
            &json!("urn:raceway:problem:unknown-channel"),
            &json!("no signal of this kind is kept; see outputs in the request")
        )
    );
}

#[test]
fn wrong_queries_are_refused() {
    let server = start();
    let path = finished(&server);
    for query in [
        "spectrum?channel=spindle.y.acceleration&max_frequency_hz=-1",
        "spectrum?channel=spindle.y.acceleration&max_frequency_hz=NaN",
        "spectrum?channel=spindle.y.acceleration&kind=power",
        "spectrum?channel=spindle.y.acceleration&colour=red",
        "spectrum?channel=spindle.y.acceleration&kind=envelope&quantity=velocity",
        "bands?edges_hz=300",
        "bands?edges_hz=300,x",
        "bands?edges_hz=1800,300",
        "bands?edges_hz=300,30000",
        "series?channel=spindle.y.velocity&from_s=1&to_s=0",
        "series?channel=spindle.y.velocity&max_points=0",
        "series?channel=spindle.y.velocity&max_points=1.5",
    ] {
        server.get(&format!("{path}/{query}")).problem(400);
    }
    for suffix in ["/spectrum?channel=spindle.y.acceleration", "/metrics", "/plots/spectrum.svg", ""] {
        let answer = request(server.address(), "GET", &format!("{path}{suffix}"), &[("Accept", "image/png")], b"");
        answer.problem(406);
    }
}

#[test]
fn the_contract_of_the_metrics_holds() {
    let server = start();
    let path = finished(&server);
    let metrics = server.get(&format!("{path}/metrics")).json();
    for pointer in [
        "/channels/spindle.y.acceleration/rms",
        "/channels/spindle.z.velocity/peak",
        "/channels/spindle.y.acceleration/above_band",
        "/contacts/inner/max_load_n",
        "/contacts/outer/max_pressure_mpa",
        "/kinematics/cage_speed_hz",
        "/frequencies_hz/ball_pass_outer",
        "/lines",
        "/envelope_lines",
        "/solver/method",
        "/solver/wall_time_s",
        "/accuracy/how",
        "/left_out",
    ] {
        assert!(metrics.pointer(pointer).is_some_and(|value| !value.is_null()), "{pointer}");
    }
}

/// An interrupted transfer of a series goes on with the bytes that are missing.
#[test]
fn a_series_is_sent_in_parts() {
    let server = start();
    let path = server.submit(&job_with(json!({ "outputs": { "series": ["spindle.y.velocity"] } })));
    server.wait_for(&path, &["succeeded"]);
    let get = |query: &str, more: &[(&str, &str)]| {
        let headers = [&[("Accept", "application/x-npy"), ("Accept-Encoding", "gzip")], more].concat();
        request(server.address(), "GET", &format!("{path}/series{query}"), &headers, b"")
    };
    let whole = get("", &[]);
    // 102 values of 1 ms: 16 bytes each, after a head of 128.
    let length = whole.header("content-length");
    assert_eq!((whole.status, length, whole.header("content-encoding")), (200, Some("1760"), None));
    assert_eq!(whole.header("accept-ranges"), Some("bytes"));
    let tag = whole.header("etag").expect("a result has a tag");
    for (range, place, length) in [("0-9", "0-9", "10"), ("1000-", "1000-1759", "760"), ("-1", "1759-1759", "1")] {
        let part = get("", &[("Range", &format!("bytes={range}")), ("If-Range", tag)]);
        assert_eq!((part.status, part.header("content-length")), (206, Some(length)), "{range}");
        assert_eq!(part.header("content-range"), Some(&*format!("bytes {place}/1760")));
        assert_eq!(part.header("etag"), Some(tag));
    }
    assert_eq!(get("", &[("Range", "bytes=0-9"), ("If-Range", "\"other\"")]).status, 200);
    assert_eq!(get("", &[("Range", "bytes=0-9"), ("If-None-Match", tag)]).status, 304);
    let beyond = get("", &[("Range", "bytes=1760-")]);
    assert_eq!(beyond.problem(416)["type"], "urn:raceway:problem:range-not-satisfiable");
    assert_eq!(beyond.header("content-range"), Some("bytes */1760"));
    assert_eq!(get("?max_points=10", &[("Range", "bytes=0-9")]).header("content-range"), Some("bytes 0-9/288"));
    let as_text = request(server.address(), "GET", &format!("{path}/series"), &[("Range", "bytes=0-9")], b"");
    assert_eq!(as_text.status, 200);
}
