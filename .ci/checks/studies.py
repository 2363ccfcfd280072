#!/usr/bin/env python3
"""A map of 20 × 20 points, cancelled during its run, resumed and killed, gives the table of an undisturbed run. Two workers against one."""

import os
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, check  # noqa: E402


LEVEL = "/channels/spindle.y.acceleration/level_db"


def study(count):
    return ARTICLE | {
        "kind": "study", "reuse": False, "settle_s": 0.02, "duration_s": 0.05, "outputs": {"metrics": ["vibration"]},
        "solver": {"model_tolerance_db": 0.2},
        "axes": [{"path": "/operation/speed_rpm", "from": 30000, "to": 60000, "count": count},
                 {"path": "/bearing/radial_clearance_um", "from": 2, "to": 10, "count": count}],
    }


def table(service, path):
    return service.request("GET", f"{path}/table")[2]


def timeless(answer):
    for row in answer["rows"]:
        for field in ("wall_time_s", "real_time_factor"):
            row["metrics"]["solver"].pop(field)
    return answer["rows"]


def reach(service, path, ended):
    while table(service, path)["ended"] < ended:
        time.sleep(0.05)


with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory, "--workers", "2")
    path, _ = service.submit(study(20))
    reach(service, path, 80)
    check(service.request("POST", f"{path}/cancel")[0] in (200, 202), "a study is cancelled in the middle")
    service.until(path, lambda job: job["status"] == "cancelled", at_most=2)
    kept = table(service, path)["ended"]
    check(80 <= kept < 400, f"and keeps its {kept} points of 400")
    check(service.request("POST", f"{path}/resume")[0] == 202, "it is resumed")
    reach(service, path, 200)
    service.kill()
    service = Service(directory, "--workers", "2")
    try:
        check(table(service, path)["ended"] >= 200, "finished points survive a kill")
        check(service.ended(path)["status"] == "succeeded", "the killed study succeeds without help")
        disturbed = timeless(table(service, path))
        again, _ = service.submit(study(20))
        check(service.ended(again)["status"] == "succeeded", "the same study succeeds undisturbed")
        check(timeless(table(service, again)) == disturbed, "both studies have the same table")
        picture = service.request("GET", f"{path}/plots/map.svg")
        check(picture[0] == 200 and b"</svg>" in picture[2], "drawn as a map")
    finally:
        service.stop()

with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    service = Service(directory)
    try:
        # The optimum of one parameter, against a study on a fine grid.
        wish = ARTICLE | {"kind": "optimum", "settle_s": 0.02, "duration_s": 0.05, "metric": LEVEL, "solver": {"rung": "radially_condensed"},
                          "axes": [{"path": "/bearing/radial_clearance_um", "from": 2, "to": 8}]}
        path, _ = service.submit(wish)
        check(service.ended(path)["status"] == "succeeded", "an optimum is found")
        found = service.request("GET", f"{path}/optimum")[2]
        grid = wish | {"kind": "study", "axes": [wish["axes"][0] | {"count": 121}], "outputs": {"metrics": ["vibration"]}}
        del grid["metric"]
        path, _ = service.submit(grid)
        service.ended(path)
        best = table(service, path)["best"][LEVEL]
        print(f"optimum {found['value']:.4f} dB at {found['point']} in {found['runs']} runs; best of 121 points {best['value']:.4f} dB at {best['point']}")
        check(found["value"] <= best["value"] + found["error"] + best["error"], "no point of a fine grid is better")
    finally:
        service.stop()

times = []
for workers in ("1", "2"):
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        service = Service(directory, "--workers", workers)
        # The time of the start of the process does not count.
        service.ended(service.submit(study(2))[0])
        begin = time.monotonic()
        path, _ = service.submit(study(16))
        service.ended(path)
        times.append(time.monotonic() - begin)
        service.stop()
print(f"256 points: {times[0]:.1f} s on one worker, {times[1]:.1f} s on two: {times[0] / times[1]:.2f} times as fast (goal 1.8)")
