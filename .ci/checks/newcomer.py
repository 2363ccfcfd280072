#!/usr/bin/env python3
"""The shell block of the README from a catalogue to a labelled spectrum, run unchanged against a service."""

import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, check, service  # noqa: E402

with open(os.path.join(ROOT, "README.md"), encoding="utf-8") as readme:
    found = re.search(r"<!-- \.ci/checks/newcomer\.py[^\n]*-->\n```sh\n(.*?)```", readme.read(), re.DOTALL)
check(found is not None, "README.md has its marked block")
block = found.group(1)
check("http://127.0.0.1:8080" in block, "the block uses the default address")

with service() as running, tempfile.TemporaryDirectory() as directory:
    script = block.replace("http://127.0.0.1:8080", running.url)
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", script], cwd=directory, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=180)
    check(done.returncode == 0, f"the block ends well {done.stderr}")
    check(block.count("curl ") == 2 and "sleep" not in block, "two requests, and no loop")
    check('"status":"succeeded"' in done.stdout, "the job has succeeded")
    check('"level_db"' in done.stdout, "the metrics hold levels")
    labels = set(re.findall(r'"label":"([^"]*)"', done.stdout))
    check("BPFO" in labels and any("f_r" in label for label in labels), f"lines are labelled, among them {sorted(labels)[:4]}")
    picture = os.path.join(directory, "spectrum.svg")
    root = xml.etree.ElementTree.parse(picture).getroot()
    check(root.tag.endswith("svg"), "spectrum.svg is well-formed")
    check("BPFO" in "".join(root.itertext()), "spectrum.svg names BPFO")
    # Other statements of the README near the block.
    jobs = running.request("GET", "/v1/jobs")[2]["jobs"]
    path = f"/v1/jobs/{jobs[0]['id']}"
    status, headers, table = running.request(
        "GET", f"{path}/spectrum?channel=spindle.y.acceleration", headers={"Accept": "text/csv"})
    check(status == 200 and headers.get_content_type() == "text/csv" and b"," in table, "the spectrum comes as CSV")
    check(running.request("POST", "/v1/scenes/resolve", jobs[0]["request"])[0] == 200, "the same body is resolved")
    check("6205" in running.request("GET", "/v1/presets")[2]["bearings"], "the preset is there")
    wrong = {"kind": "simulation", "scene": {"bearing": {"preset": "6205", "ball_diameter_mm": -1}, "operation": {"speed_rpm": 1}}}
    status, headers, problem = running.request("POST", "/v1/jobs", wrong)
    check(status == 422 and headers.get_content_type() == "application/problem+json", "a wrong field is refused")
    check(problem["errors"][0]["pointer"] == "/scene/bearing/ball_diameter_mm", "and named")
    check(running.request("GET", "/docs/")[0] == 200, "the API's page is there")
