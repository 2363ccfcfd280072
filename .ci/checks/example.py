#!/usr/bin/env python3
"""The example of the page, `src/api/portal/example.json`, is what this program answers to the scene with which the form opens. With `--write`
it is recorded."""

import json
import math
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from service import ROOT, check, service

PORTAL = os.path.join(ROOT, "src", "api", "portal")
PATH = os.path.join(PORTAL, "example.json")
LIMIT_HZ = 5000
"""Highest frequency of the recorded spectra: the page shows less of this run."""

TIMES = ("wall_time_s", "real_time_factor")
"""Fields that differ from run to run."""

DIGITS = 4
"""Digits that the page prints."""


def start():
    """The request of the form as it opens."""
    with open(os.path.join(PORTAL, "request.js"), encoding="utf-8") as source:
        text = re.search(r"export const START = (\{.*?\n\});", source.read(), re.DOTALL).group(1)
    quoted = re.sub(r"(\w+):", r'"\1":', text).replace("'", '"')
    return json.loads(re.sub(r",(\s*[}\]])", r"\1", quoted))


def answered(running, request):
    """What the page needs of the answer to a request."""
    place, _ = running.submit(request)
    check(running.ended(place)["status"] == "succeeded", "the example runs")
    metrics = running.request("GET", f"{place}/metrics")[2]
    channels = request.get("outputs", {}).get("spectra", ["spindle.y.acceleration", "spindle.z.acceleration"])
    spectrum = lambda channel, kind: running.request(
        "GET", f"{place}/spectrum?channel={channel}&kind={kind}&max_frequency_hz={LIMIT_HZ}")[2]
    spectra = [spectrum(channel, kind) for channel in channels for kind in ("amplitude", "envelope")]
    version = running.request("GET", "/openapi.json")[2]["info"]["version"]
    return {"version": version, "request": request, "metrics": metrics, "spectra": spectra}


def differences(recorded, now, pointer=""):
    """Pointers to the values that differ in their printed digits. A line or a bin far below the largest may differ by that much of it."""
    if isinstance(recorded, dict) and isinstance(now, dict):
        names = sorted(recorded.keys() | now.keys())
        return [found for name in names if name not in TIMES
                for found in differences(recorded.get(name), now.get(name), f"{pointer}/{name}")]
    if isinstance(recorded, list) and isinstance(now, list) and len(recorded) == len(now):
        return [found for i, pair in enumerate(zip(recorded, now)) for found in differences(*pair, f"{pointer}/{i}")]
    if isinstance(recorded, float) and isinstance(now, (int, float)):
        same = math.isclose(recorded, now, rel_tol=0.5 * 10 ** (1 - DIGITS), abs_tol=1e-9)
        return [] if same else [f"{pointer}: {recorded} is now {now}"]
    return [] if recorded == now else [f"{pointer}: {recorded} is now {now}"]


with service() as running:
    now = answered(running, start())
    if "--write" in sys.argv[1:]:
        with open(PATH, "w", encoding="utf-8") as file:
            json.dump(now, file, ensure_ascii=False, separators=(",", ":"), sort_keys=True)
            file.write("\n")
    with open(PATH, encoding="utf-8") as file:
        found = differences(json.load(file), json.loads(json.dumps(now)))
    check(not found, f"example.json is the answer of this program; else run {os.path.relpath(__file__, ROOT)} --write {found[:5]}")
