#!/usr/bin/env python3
"""Local defects of the raceways sound at their lines. With a URL as argument the checks talk to a service that runs there."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from cases import metrics, run_cases, verdict  # noqa: E402

Y = "spindle.y.acceleration"


def motor(surfaces, **fields):
    """A 6205 under 500 N at 1797 r/min."""
    return {"kind": "simulation", "settle_s": 0.2, "duration_s": 0.5, "solver": {"rung": "planar"}, "outputs": {"spectra": [Y]},
            "scene": {"bearing": "6205", "operation": {"speed_rpm": 1797, "radial_load_y_n": 500}, "surfaces": surfaces}, **fields}


def slot(**fields):
    return {"defects": [{"length_mm": 1, "depth_um": 10, **fields}]}


def labels(found):
    return [line["label"] for line in found.get("lines", []) if line["channel"] == Y][:8]


def case_outer_defect(running):
    found, ideal = metrics(running, motor({"outer": slot()})), metrics(running, motor({}))
    names = labels(found)
    verdict(names and all(name.endswith("BPFO") for name in names), f"outer defect, harmonics of BPFO: {names}")
    rms = [one.get("channels", {}).get(Y, {}).get("rms", 0) for one in (found, ideal)]
    verdict(rms[0] > 10 * rms[1] > 0, f"outer defect of 1 mm, louder than ideal raceways: {rms} m/s²")


def case_inner_defect(running):
    names = labels(metrics(running, motor({"inner": slot()})))
    beside = [name for name in names if "BPFI" in name and "f_r" in name]
    verdict(beside and all("BPFI" in name for name in names), f"inner defect, BPFI with sidebands of f_r: {names}")


def case_resolve_describes_defects(running):
    answer = running.request("POST", "/v1/scenes/resolve", {"scene": motor({"outer": slot(), "inner": slot()})["scene"]})[2]
    surfaces = answer.get("derived", {}).get("surfaces", {})
    drops = [(surfaces.get(ring, {}).get("defects") or [{}])[0].get("edge_drop_um", 0) for ring in ("outer", "inner")]
    verdict(abs(drops[0] - 26.2) < 0.1 and abs(drops[1] - 39.5) < 0.1, f"drop between edges 1 mm apart, outer and inner: {drops} µm")


def refused(running, surfaces, pointer, **fields):
    status, _, answer = running.request("POST", "/v1/jobs", motor(surfaces, **fields))
    errors = answer.get("errors", []) if isinstance(answer, dict) else []
    verdict(status == 422 and [error["pointer"] for error in errors] == [pointer], f"refused at {pointer}: {status} {errors}")


def case_refusals(running):
    two = {"outer": {"defects": [slot()["defects"][0], {"azimuth_deg": 1, "length_mm": 1, "depth_um": 5}]}}
    refused(running, two, "/scene/surfaces/outer/defects/1")
    refused(running, {"outer": slot(depth_um=2000)}, "/scene/surfaces/outer/defects/0/depth_um")
    refused(running, {"outer": slot(width_mm=1, across_mm=0.5)}, "/solver/rung")
    refused(running, {"outer": slot()}, "/solver/fixed_step_us",
            solver={"rung": "planar", "method": "dormand_prince", "fixed_step_us": 50})


def case_condensed_level(running):
    """Balls stay in a shallow spall: the radially condensed level agrees with the planar one. They leave it outside the load."""
    condensed, planar = ({"rung": rung} for rung in ("radially_condensed", "planar"))
    levels = [metrics(running, motor({"outer": slot(depth_um=3)}, solver=solver)).get("channels", {}).get(Y, {}).get("level_db", 0)
              for solver in (condensed, planar)]
    verdict(all(levels) and abs(levels[0] - levels[1]) < 0.2, f"spall of 1 mm and 3 µm, radially condensed and planar: {levels} dB")
    refused(running, {"outer": slot(azimuth_deg=180)}, "/solver/rung", solver=condensed)
    refused(running, {"balls": [{"ball": 1, "defects": [{"diameter_mm": 0.4, "depth_um": 2}]}]}, "/solver/rung", solver=condensed)


run_cases(globals())
