#!/usr/bin/env python3
"""Loads over time move the spindle as an oscillator answers them. With a URL as argument the checks talk to a service that runs there."""

import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import finished, metrics, run_cases, verdict  # noqa: E402

DISPLACEMENT = "spindle.y.displacement"


def turning(loads, solver=None, **operation):
    """The article's bearing at 50 000 r/min under loads."""
    return {"kind": "simulation", "settle_s": 0.02, "duration_s": 0.05, "solver": solver or {"rung": "radially_condensed"},
            "outputs": {"metrics": ["vibration"]},
            "scene": {"bearing": "article-integrated",
                      "operation": {"speed_rpm": 50000, "radial_load_y_n": 200, **operation, "loads": loads}}}


def level(found):
    return found.get("channels", {}).get("spindle.y.acceleration", {}).get("level_db", float("nan"))


def case_constant_load_is_the_radial_load(running):
    plain = turning([])
    del plain["scene"]["operation"]["loads"]
    loads = [{"direction": "y", "constant_n": 200}]
    levels = [level(metrics(running, plain)), level(metrics(running, turning(loads, radial_load_y_n=0)))]
    verdict(levels[0] == levels[1], f"200 N as a constant load and as a radial load give one level: {levels} dB")


def case_rotating_load_is_an_unbalance(running):
    speed = 50000 * math.pi / 30
    unbalanced = turning([])
    del unbalanced["scene"]["operation"]["loads"]
    unbalanced["scene"]["spindle"] = {"unbalance_g_mm": 0.3}
    loads = [{"rotating": {"amplitude_n": 0.3e-6 * speed**2, "order": 1}}]
    levels = [level(metrics(running, unbalanced)), level(metrics(running, turning(loads)))]
    verdict(abs(levels[0] - levels[1]) < 1e-6, f"an unbalance and a rotating load of its force give one level: {levels} dB")


def case_line_of_a_harmonic_load(running):
    loads = [{"direction": "y", "harmonic": {"amplitude_n": 20, "frequency_hz": 1500}}]
    lines = metrics(running, turning(loads)).get("lines", [])
    found = [line["frequency_hz"] for line in lines if line["label"] == "load" and "y" in line["channel"]]
    verdict(len(found) == 1 and abs(found[0] - 1500) < 5, f"a harmonic load of 1500 Hz has the line `load`: {found}")


def case_shock(running):
    """A preloaded bearing at rest is an oscillator without damping. Half a sine of half its period has the response factor π/2."""
    scene = {"bearing": {"preset": "article-integrated", "radial_clearance_um": -20}, "gravity_m_s2": 0,
             "damping": {"raceway": {"law": "none"}}, "operation": {"speed_rpm": 0}}
    answer = running.request("POST", "/v1/scenes/resolve", {"scene": scene})[2]
    frequency = max((one["frequency_hz"] for one in answer["derived"].get("resonances", [])), default=6554)
    mass = answer["scene"]["spindle"]["mass_kg"]
    stiffness = mass * (2 * math.pi * frequency) ** 2
    scene["operation"]["loads"] = [
        {"direction": "y", "shock": {"peak_n": 1, "at_s": 2e-3, "duration_s": 0.5 / frequency}}]
    ended = finished(running, {"kind": "simulation", "scene": scene, "settle_s": 1e-3, "duration_s": 0.01,
                               "solver": {"relative_tolerance": 1e-8},
                               "outputs": {"metrics": ["vibration"], "spectra": [], "series": [DISPLACEMENT]}})
    factor = float("nan")
    if ended:
        series = running.request("GET", f"/v1/jobs/{ended['id']}/series?channel={DISPLACEMENT}&max_points=4000")[2]
        values = series["value"]
        factor = 1e-6 * (max(values) - values[0]) * stiffness
    verdict(abs(factor - math.pi / 2) < 0.01, f"response factor of a shock of half a period: {factor:.4f}, π/2 is 1.5708")


def case_refusals(running):
    for load, pointer in [
        ({"direction": "y"}, "/scene/operation/loads/0"),
        ({"direction": "x", "constant_n": 1}, "/scene/operation/loads/0/direction"),
        ({"direction": "about_z", "constant_n_m": 1}, "/scene/operation/loads/0/direction"),
        ({"direction": "y", "shock": {"peak_n": 1, "at_s": 0, "duration_s": 0}}, "/scene/operation/loads/0/shock/duration_s"),
    ]:
        job = turning([load])
        job["scene"]["spindle"] = {"axial": "fixed"}
        status, _, answer = running.request("POST", "/v1/jobs", job)
        pointers = [error["pointer"] for error in answer.get("errors", [])]
        verdict(status == 422 and pointers == [pointer], f"{load} is refused at {pointer}: {status} {pointers}")


def case_periodic_refuses_loads_that_vary(running):
    loads = [{"direction": "y", "harmonic": {"amplitude_n": 20, "order": 2}}]
    status, _, answer = running.request("POST", "/v1/jobs", turning(loads, {"rung": "periodic"}))
    verdict(status == 422 and "operation.loads" in str(answer), f"the level periodic names the loads: {status} {answer}")


def case_resolve_describes_loads(running):
    loads = [{"direction": "z", "points": [{"at_s": 0, "n": 10}, {"at_s": 0.5, "n": 30}]},
             {"rotating": {"amplitude_n": 5, "order": 3}}]
    status, _, answer = running.request("POST", "/v1/scenes/resolve", turning(loads, {}))
    found = answer.get("derived", {}).get("loads", []) if status == 200 else []
    described = [(one["kind"], one["at_start"], one["largest_change"], one.get("frequency_hz"), one.get("end_s")) for one in found]
    expected = [("points", 10, 20, None, 0.5), ("rotating", 0, 5, 2500, None)]
    verdict(described == expected, f"resolve describes each load: {described}")


def case_uploaded_series(running):
    """A harmonic load as values at 20 kHz gives its level. Longer steps, which err by 0.01 dB, are tried only under loads that repeat."""
    rate, frequency = 20000, 300
    values = [20 * math.sin(2 * math.pi * frequency * k / rate) for k in range(2 * rate)]
    status, _, stored = running.request("POST", "/v1/series", {"rate_hz": rate, "values": values})
    harmonic = {"direction": "y", "harmonic": {"amplitude_n": 20, "frequency_hz": frequency, "phase_deg": -90}}
    series = {"direction": "y", "series": {"hash": stored.get("hash", "0" * 64)}}
    levels = [level(metrics(running, turning([load]))) for load in (harmonic, series)]
    verdict(status == 201 and abs(levels[0] - levels[1]) < 0.03, f"a harmonic load and its values have one level: {status} {levels} dB")


def case_series_is_shown_and_deleted(running):
    stored = running.request("POST", "/v1/series", {"rate_hz": 1000, "values": [0, 1, 0.5]})[2]
    path = f"/v1/series/{stored.get('hash')}"
    shown = running.request("GET", path)[2]
    statuses = [running.request("DELETE", path)[0], running.request("GET", path)[0]]
    verdict(shown.get("values") == 3 and statuses == [204, 404], f"a series is shown and deleted: {shown} {statuses}")


run_cases(globals())
