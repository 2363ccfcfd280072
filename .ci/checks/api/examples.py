#!/usr/bin/env python3
"""Records the examples of the OpenAPI document from a run of the service. Long lists are shortened.

    .ci/checks/api/examples.py > src/api/examples.json"""

import json
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, os.pardir))
from service import Service  # noqa: E402
import tempfile  # noqa: E402

SCENE = {"bearing": "6205", "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}}
OUTPUTS = {"spectra": ["spindle.y.acceleration"], "series": ["spindle.y.displacement"]}
CURVATURE = "/bearing/inner_groove_curvature"
JOBS = {
    "simulation": {"kind": "simulation", "scene": SCENE, "outputs": OUTPUTS, "labels": ["line 3"]},
    "study": {"kind": "study", "scene": SCENE, "axes": [{"path": CURVATURE, "values": [0.515, 0.52]}]},
    "optimum": {"kind": "optimum", "scene": SCENE, "axes": [{"path": CURVATURE, "from": 0.51, "to": 0.54}],
                "metric": "/channels/spindle.y.acceleration/level_db"},
    "uncertainty": {"kind": "uncertainty", "scene": SCENE, "samples": 16, "inputs": [
        {"path": "/bearing/radial_clearance_um", "distribution": {"type": "clearance_group", "group": "CN"}},
        {"path": "/operation/speed_rpm", "distribution": {"type": "uniform", "from": 5900, "to": 6100}}]},
    "accuracy": {"kind": "accuracy", "scene": SCENE, "methods": ["gear", "dormand_prince"],
                 "relative_tolerances": [1e-3, 1e-4], "duration_s": 0.02},
}
ROTOR = {
    "kind": "rotor",
    "scene": {
        "shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}], "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]},
        "supports": [{"at_mm": at, "stiffness_n_per_um": [0, 50, 50], "damping_n_s_per_m": [0, 200, 200]} for at in (40, 260)],
        "operation": {"speed_rpm": 12000}},
    "speeds_rpm": {"from": 0, "to": 60000, "count": 3},
}
RUN_UP = {
    "kind": "simulation",
    "scene": {"bearing": "6205", "operation": {"speed_rpm": [{"at_s": 0.05, "rpm": 3000}, {"at_s": 0.45, "rpm": 9000}], "radial_load_y_n": 500}},
    "settle_s": 0.05, "duration_s": 0.4,
    "outputs": {"spectra": [], "orders": {"tracks": ["1", "BPFO"], "turns_per_block": 8}},
}
MACHINE = {
    "kind": "machine",
    "scene": {
        "shaft": {"sections": [{"length_mm": 300, "outer_diameter_mm": 25}], "unbalances": [{"at_mm": 150, "unbalance_g_mm": 20}]},
        "bearings": [{"name": name, "bearing": "6205", "at_mm": at, "faces": faces} for name, at, faces in (("A", 40, "+x"), ("B", 260, "-x"))],
        "preloads": [{"between": ["A", "B"], "force_n": 200}],
        "operation": {"speed_rpm": 6000}},
    "duration_s": 0.02, "settle_s": 0.02,
}
# Number of entries of a long list or map.
SHOWN = 2
MAPS = ("bearings", "materials", "lubricants", "channels", "best", "trends")


def shortened(answer, name=""):
    if isinstance(answer, list):
        # A vector stays whole.
        is_vector = len(answer) == 3 and all(isinstance(entry, (int, float)) for entry in answer)
        return answer if is_vector else [shortened(entry) for entry in answer[:SHOWN]]
    if isinstance(answer, dict):
        kept = list(answer)[:SHOWN] if name in MAPS else answer
        return {key: shortened(answer[key], key) for key in kept}
    return answer


def recorded(running):
    def answer(method, path, body=None, **headers):
        return running.request(method, path, body, headers)[2]

    path, accepted = running.submit(JOBS["simulation"])
    examples = {"submitJob": {"202": accepted}}
    running.ended(path)
    examples["submitJob"]["200"] = answer("POST", "/v1/jobs", JOBS["simulation"], Prefer="wait=30")
    examples["showJob"] = {"200": answer("GET", path)}
    examples["getMetrics"] = {"200": answer("GET", f"{path}/metrics")}
    examples["submitJobs"] = {"200": answer("POST", "/v1/jobs/batch", {"jobs": [JOBS["simulation"], {"kind": "simulation"}]})}
    examples["getChannels"] = {"200": answer("GET", f"{path}/channels")}
    examples["getSpectrum"] = {"200": answer("GET", f"{path}/spectrum?channel=spindle.y.acceleration&max_frequency_hz=20")}
    examples["getBands"] = {"200": answer("GET", f"{path}/bands?edges_hz=300,1800,10000")}
    examples["getSeries"] = {"200": answer("GET", f"{path}/series?channel=spindle.y.displacement&max_points=4")}
    # A signal of its own: a measured record of 0.25 s with the line BPFO.
    tone = [math.sin(2 * math.pi * 358.5 * k / 51200) for k in range(12800)]
    measured = {"series": answer("POST", "/v1/series", {"rate_hz": 51200, "values": tone})["hash"], "unit": "g", "speed_rpm": 5990, "gain": 0.5}
    examples["compareMeasurement"] = {"200": answer("POST", f"{path}/comparison", measured)}
    run_up = running.submit(RUN_UP)[0]
    running.ended(run_up)
    examples["getOrders"] = {"200": answer("GET", f"{run_up}/orders")}
    examples["getWaterfall"] = {"200": answer("GET", f"{run_up}/waterfall")}
    ends = {}
    for kind in ("optimum", "accuracy", "study", "uncertainty"):
        ends[kind] = running.submit(JOBS[kind])[0]
        running.ended(ends[kind], at_most=300)
    examples["listJobs"] = {"200": answer("GET", "/v1/jobs?limit=1")}
    examples["getTable"] = {"200": answer("GET", f"{ends['study']}/table")}
    examples["getUncertainty"] = {"200": answer("GET", f"{ends['uncertainty']}/uncertainty")}
    examples["getOptimum"] = {"200": answer("GET", f"{ends['optimum']}/optimum")}
    examples["getAccuracy"] = {"200": answer("GET", f"{ends['accuracy']}/accuracy")}
    long = running.submit(JOBS["study"] | {"axes": [{"path": CURVATURE, "from": 0.51, "to": 0.54, "count": 500}]})[0]
    waiting = running.submit(JOBS["simulation"] | {"reuse": False})[0]
    running.until(long, lambda job: job["status"] == "running")
    examples["cancelJob"] = {"202": answer("POST", f"{long}/cancel"), "200": answer("POST", f"{waiting}/cancel")}
    running.ended(long)
    examples["resumeStudy"] = {"202": answer("POST", f"{long}/resume")}
    answer("POST", f"{long}/cancel")
    running.ended(long)
    examples["resolveScene"] = {"200": answer("POST", "/v1/scenes/resolve", {"scene": SCENE})}
    examples["listPresets"] = {"200": answer("GET", "/v1/presets")}
    examples["searchCatalogue"] = {"200": answer("GET", "/v1/catalogue?series=62&bore_mm=25")}
    series = answer("POST", "/v1/series", {"rate_hz": 1000, "values": [0, 12.5, 20, 12.5, 0]})
    examples["uploadSeries"] = {"201": series}
    examples["showSeries"] = {"200": answer("GET", f"/v1/series/{series['hash']}")}
    examples["listSeries"] = {"200": answer("GET", "/v1/series")}
    short = {"outputs": {"metrics": ["vibration"], "spectra": ["spindle.y.acceleration"]}, "solver": {"model_tolerance_db": 1}}
    examples["previewRun"] = {"200": answer("POST", "/v1/preview", {"kind": "simulation", "scene": SCENE, **short})}
    examples["resolveMachine"] = {"200": answer("POST", "/v1/machine/resolve", MACHINE)}
    examples["analyseRotor"] = {"200": answer("POST", "/v1/rotor", ROTOR)}
    rotor = running.submit(ROTOR)[0]
    running.ended(rotor)
    examples["getRotor"] = {"200": answer("GET", f"{rotor}/rotor")}
    machine = running.submit(MACHINE)[0]
    running.ended(machine)
    examples["getMachine"] = {"200": answer("GET", f"{machine}/machine")}
    examples["isAlive"] = {"200": answer("GET", "/health/live")}
    examples["isReady"] = {"200": answer("GET", "/health/ready")}
    return examples


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as directory:
        service = Service(directory, "--workers", "1")
        try:
            examples = recorded(service)
        finally:
            service.stop()
    json.dump(shortened(examples), sys.stdout, indent=1, ensure_ascii=False, sort_keys=True)
    print()
