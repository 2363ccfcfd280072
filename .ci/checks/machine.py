#!/usr/bin/env python3
"""Machine jobs over HTTP: a shaft on two bearings in time against the linear analysis of the same scene, a spall seen by a sensor, refusals by
pointer. With a URL as argument the requests go there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
from cases import result, run_cases, verdict  # noqa: E402

SPALL = {"outer": {"defects": [{"azimuth_deg": 0, "length_mm": 1, "width_mm": 2, "depth_um": 3}]}}


def scene(first=None, **changes):
    """A bar with a disc in the middle on two preloaded bearings, changed; `first`: more fields of the first bearing."""
    bearings = [{"name": name, "bearing": "6205", "at_mm": at, "faces": faces} for name, at, faces in (("A", 40, "+x"), ("B", 260, "-x"))]
    bearings[0] |= first or {}
    return {
        "shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}],
                  "discs": [{"at_mm": 150, "mass_kg": 1.2, "transverse_inertia_kg_m2": 8e-4, "axial_inertia_kg_m2": 1.5e-3}],
                  "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]},
        "bearings": bearings,
        "preloads": [{"between": ["A", "B"], "force_n": 200}],
        "sensors": [{"name": "probe", "at_mm": 200, "direction": "y"}],
        "operation": {"speed_rpm": 12000, "radial_load_y_n": 100}} | changes


def job(duration=0.05, settle=0.05, **fields):
    return {"kind": "machine", "scene": scene(), "duration_s": duration, "settle_s": settle} | fields


def case_agrees_with_the_linear_analysis(running):
    run = result(running, job(duration=0.1, settle=0.4), "machine")
    status, _, linear = running.request("POST", "/v1/rotor", {"kind": "rotor", "scene": scene(), "speeds_rpm": [12000]})
    if status != 200:
        return verdict(False, f"the rotor analysis takes the scene of a machine: {status} {linear}")
    force, rest = run["channels"]["A.force.y"]["mean"], linear["supports"][0]["static_force_n"][1]
    verdict(abs(force / rest - 1) < 1e-3, f"mean force of the shaft on A: {force:.3f} N, static {rest:.3f} N")
    seen = run["channels"]["A.y.displacement"]["rms"] * 2**0.5
    foretold = next(place for place in linear["response"] if abs(place["at_mm"] - 40) < 1e-6)["y_um"][0]
    verdict(abs(seen / foretold - 1) < 0.02, f"amplitude at A by unbalance: {seen:.5f} µm, linear {foretold:.5f} µm")
    found = [mode["frequency_hz"] for mode in run["natural_frequencies"]][:4]
    known = [mode["frequency_hz"] for mode in linear["operating"]["modes"]][:4]
    verdict(all(abs(one / other - 1) < 1e-4 for one, other in zip(found, known)), f"natural frequencies {found} and {known} Hz")
    errors = run["accuracy"]["level_errors_db"]
    verdict(errors and max(errors.values()) <= 0.1, f"errors of the levels {errors} dB")
    return None


def case_plan(running):
    body = job(duration=0.1)
    status, _, plan = running.request("POST", "/v1/machine/resolve", body)
    verdict(status == 200 and plan["coordinates"] > 10 and plan["step_us"] == 5.5, f"a plan: {status} {plan.get('step_us')} µs")
    orders = [bearing["frequencies_hz"]["ball_pass_outer"] / 200 for bearing in plan["bearings"]]
    verdict(all(abs(order - 3.585) < 1e-3 for order in orders), f"BPFO orders {orders}")
    cost = plan["cost"]
    verdict(0 < cost["estimated_wall_time_s"] <= cost["most_wall_time_s"], f"expected time {cost}")
    ended = [running.ended(running.submit(one)[0]) for one in (body, plan["job"])]
    verdict([one["status"] for one in ended] == ["succeeded"] * 2 and ended[1]["reused"], "the planned job is the same work")
    status, _, refusal = running.request("POST", "/v1/machine/resolve", job(scene=scene(shaft={"sections": []})))
    verdict(status == 422 and refusal["errors"][0]["pointer"].startswith("/scene/shaft"), f"refusals as those of a job: {refusal}")


def case_spall_at_a_sensor(running):
    body = job(duration=0.1, scene=scene(first={"surfaces": SPALL}))
    run = result(running, body, "machine")
    labels = [line["label"] for line in run["lines"] if line["channel"] == "sensor.probe.acceleration"]
    verdict(sum(label.endswith("BPFO@A") for label in labels) >= 5, f"lines at the sensor: {labels[:8]}")
    path, _ = running.submit(body)
    ended = running.ended(path)
    verdict(ended["reused"], "an identical machine job is answered by its result")
    channels = running.request("GET", f"{path}/channels")[2]
    verdict("sensor.probe.acceleration" in channels["envelopes"], f"channels {channels['spectra']}")
    spectrum = running.request("GET", f"{path}/spectrum?channel=A.y.acceleration")[2]
    verdict(spectrum["unit"] == "m/s²" and max(spectrum["amplitude"]) > 0.1, "the spectrum of a bearing")
    status, _, drawing = running.request("GET", f"{path}/plots/spectrum.svg")
    drawing = drawing.decode() if isinstance(drawing, bytes) else str(drawing)
    verdict(status == 200 and "BPFO@A" in drawing and "sensor.probe.acceleration" in drawing, "the spectrum is drawn with labels")
    status, _, answer = running.request("GET", f"{path}/metrics")
    verdict(status in (404, 409), f"a machine job has no metrics of a simulation: {status} {answer.get('detail')}")
    # The squared envelope of a narrow band at the first bearing.
    path, _ = running.submit(body | {"outputs": {"envelope_band_hz": [1000, 6000], "envelope": "squared"}})
    verdict(running.ended(path)["status"] == "succeeded", "the band and the square of the envelope can be chosen")
    spectrum = running.request("GET", f"{path}/spectrum?channel=A.y.acceleration&kind=envelope")[2]
    verdict(spectrum["unit"] == "(m/s²)²", f"unit of a squared envelope: {spectrum['unit']}")
    squared = running.request("GET", f"{path}/machine")[2]
    labels = {line["label"] for line in squared["envelope_lines"] if line["channel"] == "A.y.acceleration"}
    verdict(squared["envelope"] == "squared" and "BPFO@A" in labels, f"its lines at the bearing: {sorted(labels)[:8]}")
    drawing = running.request("GET", f"{path}/plots/envelope.svg")[2]
    verdict("Squared-envelope spectrum" in (drawing.decode() if isinstance(drawing, bytes) else str(drawing)), "its plot says so")


def case_refusals(running):
    def pointers(**fields):
        status, _, answer = running.request("POST", "/v1/jobs", job(**fields))
        return {error["pointer"] for error in answer.get("errors", [])} if status == 422 else {f"status {status}"}

    cases = {
        "without bearings": ({"scene": {key: value for key, value in scene().items() if key not in ("bearings", "preloads")}}, "/scene/bearings"),
        "with a sensor beside the shaft": ({"scene": scene(sensors=[{"name": "s", "at_mm": 400, "direction": "y"}])}, "/scene/sensors/0/at_mm"),
        "with a sensor along a held axis": ({"scene": scene(sensors=[{"name": "s", "at_mm": 40, "direction": "x"}])}, "/scene/sensors/0/direction"),
        "with a start azimuth of 400°": ({"scene": scene(first={"start_azimuth_deg": 400})}, "/scene/bearings/0/start_azimuth_deg"),
        "with a step of 50 µs": ({"step_us": 50}, "/step_us"),
        "of 60 s": ({"duration": 60}, "/duration_s"),
        "with an envelope above the spectrum": ({"outputs": {"envelope_band_hz": [2000, 26000]}}, "/outputs/envelope_band_hz/1"),
        "with a housing without bodies": ({"scene": scene(housing={"bodies": []})}, "/scene/housing/bodies"),
        "with a term of bearings": ({"scene": scene(terms={"drag": "off"})}, "/scene/terms/drag"),
    }
    for name, (fields, pointer) in cases.items():
        found = pointers(**fields)
        verdict(found == {pointer}, f"a machine {name} is refused at {found}")


def case_growing_whirl(running):
    shaft = scene()["shaft"] | {"damping_ratio": 0.05, "rotating_share": 1}
    body = job(scene=scene(shaft=shaft, operation={"speed_rpm": 60000}), duration=0.5)
    path, _ = running.submit(body)
    ended = running.ended(path, at_most=120)
    detail = (ended.get("error") or {}).get("detail", "")
    verdict(ended["status"] == "failed" and "rotating_share" in detail and "linear analysis it decays below" in detail, f"whirl that damping drives: {ended['status']}, {detail}")


def case_whirl_by_balls(running):
    """Two close bearings hold a spindle whose balls, held by their cages, drive its whirl, where the linear analysis is stable."""
    pair = [{"name": name, "bearing": "7008C", "at_mm": at, "faces": faces} for name, at, faces in (("A", 0, "+x"), ("B", 15, "-x"))]
    spindle = {"spindle": {"mass_kg": 3, "balance_grade": 2.5}, "bearings": pair, "preloads": [{"between": ["A", "B"], "force_n": 150}]}
    for rpm, whirls in ((20000, True), (6000, False)):
        body = {"kind": "machine", "scene": spindle | {"operation": {"speed_rpm": rpm, "radial_load_y_n": 100}}, "duration_s": 0.1}
        run = result(running, body, "machine")
        unnamed = [one for one in run["messages"] if one["code"] == "unnamed-line"]
        verdict(run["is_stable"] and bool(unnamed) == whirls, f"whirl at {rpm} r/min: {[one['text'][:90] for one in unnamed]}")
        verdict(run["arrangements"] == [{"between": ["A", "B"], "arrangement": "DB"}], f"arrangement {run['arrangements']}")


def case_labels(running):
    """Two 6205 on a balanced rigid spindle of 4 kg. Nothing marks its rotation, so that no line is one of f_r or BPFI."""
    def lines(load, first):
        """Labels and deviations of the strongest lines of A."""
        pair = [{"name": name, "bearing": "6205", "at_mm": at, "faces": faces} for name, at, faces in (("A", 40, "+x"), ("B", 160, "-x"))]
        pair[0] |= first
        body = {"kind": "machine", "scene": {"spindle": {"mass_kg": 4}, "bearings": pair, "operation": {"speed_rpm": 3000, **load}}, "duration_s": 0.5}
        run = result(running, body, "machine")
        found = [line for line in run["lines"] if line["channel"].startswith("A.")]
        marked = [line["label"] for line in found if "f_r" in line["label"] or "BPFI" in line["label"]]
        verdict(not marked, f"lines of a shaft that nothing marks: {marked}")
        return run, found

    # The strongest line is the sum of twice the ball passage and five times the load.
    loads = [{"direction": "y", "constant_n": 1000}, {"direction": "y", "harmonic": {"amplitude_n": 700, "frequency_hz": 66.6}}]
    run, found = lines({"loads": loads}, {})
    named = [line["label"] for line in found]
    unnamed = [one for one in run["messages"] if one["code"] == "unnamed-line"]
    verdict("2·BPFO + 5·load@A/B" in named and not unnamed, f"sums of ball passage and load: {named[:6]}, messages {unnamed}")
    wave = {"surfaces": {"balls": [{"ball": 1, "waviness": [{"order": 6, "amplitude_nm": 300}]}]}}
    _, found = lines({"radial_load_y_n": 1000}, wave)
    strongest = max(found, key=lambda line: line["amplitude"])
    verdict("6·BSF" in strongest["label"] and strongest["label"].endswith("@A"), f"a wavy ball of A: {strongest['label']} at {strongest['frequency_hz']} Hz")


def case_terms(running):
    """Without bending the bar is rigid: its bending modes are gone, and the bound covers what that changes."""
    complete, lean = (result(running, job(duration=0.1, scene=scene(**more)), "machine") for more in ({}, {"terms": {"shaft_bending": "off"}}))
    [left_out] = lean["model"]["left_out"]
    verdict((left_out["term"], left_out["by"], left_out["unit"]) == ("shaft_bending", "convention", "dB"), f"the omission is named: {left_out}")
    levels = [run["channels"]["sensor.probe.acceleration"]["level_db"] for run in (complete, lean)]
    verdict(0.5 < abs(levels[1] - levels[0]) < left_out["bound"], f"levels of the probe {levels} dB, bound {left_out['bound']} dB")
    lowest = [run["natural_frequencies"] for run in (complete, lean)]
    verdict(len(lowest[0]) > 10 and len(lowest[1]) <= 5, f"natural frequencies: {len(lowest[0])}, of the rigid bar {len(lowest[1])}")
    status, _, linear = running.request("POST", "/v1/rotor", {"kind": "rotor", "scene": scene(terms={"shaft_bending": "off"}), "speeds_rpm": [12000]})
    known = [mode["frequency_hz"] for mode in linear["operating"]["modes"]]
    found = [mode["frequency_hz"] for mode in lowest[1]]
    verdict(status == 200 and all(abs(one / other - 1) < 1e-4 for one, other in zip(found, known)), f"rigid motions {found} and {known} Hz")
    # Within a tolerance, terms with smaller bounds are left out, and the deviation from the complete machine is stated.
    stout = scene(shaft=scene()["shaft"] | {"sections": [{"length_mm": 300, "outer_diameter_mm": 60}]}, preloads=[],
                  operation={"speed_rpm": 6000, "radial_load_y_n": 500})
    run = result(running, job(duration=0.1, scene=stout, solver={"model_tolerance_db": 0.5}), "machine")
    judged = [one["term"] for one in run["model"]["left_out"] if one["by"] == "judgement" and one.get("unit") == "dB"]
    deviations = run["accuracy"]["model_errors_db"].values()
    verdict("tilt" in judged and max(deviations) <= 0.5, f"on {run['model']['rung']} without {judged}: {max(deviations):.3f} dB")
    status, _, plan = running.request("POST", "/v1/machine/resolve", job(scene=stout, solver={"model_tolerance_db": 0.5}))
    verdict(status == 200 and judged == [one["term"] for one in plan["left_out"]], f"the plan names them: {plan.get('left_out')}")


def case_open_side(running):
    def thrust(facing):
        """Thrusts over open sides by name, of two bearings of which the second has a spring; the first one faces this way."""
        seat = {"seat": "sliding", "spring_force_n": 200, "spring_n_per_um": 1}
        bearings = [{"name": "A", "bearing": "7008C", "at_mm": 60, "faces": facing},
                    {"name": "B", "bearing": "7008C", "at_mm": 240, "faces": "-x", "outer_ring": seat}]
        pair = {"shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 40}], "axial": "free"},
                "bearings": bearings, "operation": {"speed_rpm": 3000, "radial_load_y_n": 50}}
        run = result(running, job(duration=0.01, settle=0.01, scene=pair, step_us=5.5), "machine")
        return {one["bearing"]: one["thrust_n"] for one in run["messages"] if one["code"] == "open-side"}

    verdict(thrust("-x") == {"A": 200} and thrust("+x") == {}, f"200 N over the open side of a bearing are told: {thrust('-x')}")


if __name__ == "__main__":
    run_cases(globals())
