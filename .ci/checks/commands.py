#!/usr/bin/env python3
"""Exit statuses and output streams of the commands. stdout contains only the requested output."""

import json
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, binary, check, clean_environment  # noqa: E402


def raceway(*arguments, stdin=""):
    return subprocess.run([binary(), *arguments], input=stdin, capture_output=True, text=True, timeout=120,
                          env=clean_environment())


short = ARTICLE | {"duration_s": 0.01, "settle_s": 0.001}
with tempfile.TemporaryDirectory() as directory:
    done = raceway("simulate", "-", "--output", directory, stdin=json.dumps(short))
    check(done.returncode == 0 and "channels" in json.loads(done.stdout), "simulate prints metrics as JSON")
    check({"metrics.json", "spectrum.svg"} <= set(os.listdir(directory)), "and writes its files")
check("estimated " in done.stderr, "an estimate stands on stderr")
quiet = raceway("simulate", "-", "--quiet", stdin=json.dumps(short["scene"] | {"spindle": {"mass_kg": 0.05}}))
check(quiet.returncode == 0 and quiet.stderr == "", "a scene alone is a job, and --quiet leaves stderr empty")
wrong = raceway("simulate", "-", stdin=json.dumps({"bearing": "nope", "operation": {"speed_rpm": 1}}))
check(json.loads(wrong.stderr)["errors"][0]["pointer"] == "/bearing", "pointers lead into the scene that stands alone")
refused = raceway("simulate", "-", stdin=json.dumps(short | {"duration_s": -1}))
check(refused.returncode == 2 and refused.stdout == "", "a refused job ends with 2 and an empty stdout")
check(json.loads(refused.stderr)["errors"][0]["pointer"] == "/duration_s", "the problem names the field")
check(raceway("simulate", "no-such-file.json").returncode == 2, "a missing file ends with 2")
varied = ARTICLE | {"kind": "study", "settle_s": 0.01, "duration_s": 0.05,
                    "axes": [{"path": "/bearing/ball_count", "values": [7, 12]},
                             {"path": "/bearing/ball_diameter_mm", "values": [2.778, 4]}]}
with tempfile.TemporaryDirectory() as directory:
    done = raceway("study", "-", "--output", directory, stdin=json.dumps(varied))
    check(done.returncode == 0 and "best acceleration level, Y" in done.stdout, "study prints a table with the best points")
    check("failed: invalid: /scene/bearing/ball_count" in done.stdout, "and why a point has none")
    check({"table.json", "table.csv", "map.svg"} == set(os.listdir(directory)), "and writes its files")
check(raceway("simulate", "-", stdin=json.dumps(varied)).returncode == 2, "simulate does not take a study")
with tempfile.TemporaryDirectory() as directory:
    done = raceway("article", "--figure", "14", "--quiet", "--output", directory)
    check(done.returncode == 0 and done.stdout == "" and done.stderr == "", "a figure of the article is made again")
    with open(os.path.join(directory, "FIGURE-14.md"), encoding="utf-8") as report:
        check("radial load" in report.read(), "its report is written")
    check(os.listdir(os.path.join(directory, "plots", "article")) == ["figure-14.svg"], "and its plot")
study = {"scene": ARTICLE["scene"], "settle_s": 0.001, "duration_s": 0.002, "methods": ["dormand_prince"],
         "relative_tolerances": [1e-3, 1e-5]}
with tempfile.TemporaryDirectory() as directory:
    done = raceway("accuracy", "-", "--output", directory, stdin=json.dumps(study))
    check(done.returncode == 0 and "dormand_prince" in done.stdout, "accuracy prints a table")
    check("cheapest within 0.01 dB: dormand_prince at " in done.stdout, "with a recommendation")
    check("2 runs and their references; estimated " in done.stderr, "an estimate stands on stderr")
    with open(os.path.join(directory, "accuracy.json"), encoding="utf-8") as answer:
        check([r["within_db"] for r in json.load(answer)["recommended"]][0] == 0.1, "and the JSON recommends, too")
    check({"accuracy.json", "work-precision.svg"} == set(os.listdir(directory)), "and writes its files")
refused = raceway("accuracy", "-", stdin=json.dumps(study | {"relative_tolerances": [1]}))
check(refused.returncode == 2 and refused.stdout == "", "a refused study ends with 2 and an empty stdout")
tiny = study | {"settle_s": 0, "duration_s": 1e-6}
with tempfile.TemporaryDirectory() as directory:
    done = raceway("accuracy", "-", "--quiet", "--output", directory, stdin=json.dumps(tiny))
    check(done.returncode == 0 and "motion unknown: run too short" in done.stdout,
          "a run of a microsecond reports what it is too short for")
    check(done.stderr == "", "--quiet leaves stderr empty")
shaft = {"scene": {"shaft": {"sections": [{"length_mm": 200, "outer_diameter_mm": 25}]},
                   "bearings": [{"name": name, "bearing": "6205", "at_mm": at} for name, at in (("A", 40), ("B", 160))],
                   "operation": {"speed_rpm": 6000, "radial_load_y_n": 300}},
         "mode_ranges": [0.5, 1], "reference_range": 2, "settle_s": 0.005, "duration_s": 0.005}
with tempfile.TemporaryDirectory() as directory:
    done = raceway("accuracy", "-", "--quiet", "--output", directory, stdin=json.dumps(shaft))
    check(done.returncode == 0 and "mode range" in done.stdout and "A.y.acceleration" in done.stdout,
          "accuracy of a shaft compares numbers of modes")
    check({"accuracy.json", "work-precision.svg"} == set(os.listdir(directory)), "and writes its files")
check("openapi" in json.loads(raceway("openapi").stdout), "openapi prints the document")
check(raceway("health", "--listen", "127.0.0.1:1").returncode == 1, "health without a service ends with 1")
check(raceway("--version").stdout.startswith("raceway "), "the version is printed")
