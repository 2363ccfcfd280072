#!/usr/bin/env python3
"""Results of the article's case by the release binary: lines, clearance sweep, unbalance, tolerance, chaos."""

import concurrent.futures
import json
import os
import subprocess
import sys

RACEWAY = os.environ.get("RACEWAY", "target/release/raceway")
Y, Z = "spindle.y.acceleration", "spindle.z.acceleration"


def simulate(clearance=5.0, grade=None, film="wedge", tolerance=1e-5, duration=0.1, solver=None):
    scene = {
        "bearing": {"preset": "article-integrated", "radial_clearance_um": clearance, "cage": {"film": film}},
        "operation": {"speed_rpm": 50000, "radial_load_y_n": 200},
    }
    if grade:
        scene["spindle"] = {"balance_grade": grade}
    job = {"kind": "simulation", "scene": scene, "settle_s": 0.02, "duration_s": duration,
           "solver": {"relative_tolerance": tolerance} | (solver or {"rung": "full"})}
    done = subprocess.run([RACEWAY, "simulate", "-"], input=json.dumps(job), text=True, capture_output=True, timeout=300)
    if done.returncode:
        sys.exit(done.stderr)
    return json.loads(done.stdout)


def line(metrics, channel, label):
    found = (x["amplitude"] for x in metrics["lines"] if x["channel"] == channel and x.get("label") == label)
    return next(found, 0.0)


def level(metrics, channel):
    return metrics["channels"][channel]["level_db"]


CLEARANCES = [2, 3, 3.25, 3.5, 3.75, 4, 4.25, 5, 6, 8]
cases = {"base": {}, "tight": {"tolerance": 1e-7}, "dry": {"film": "none"},
         "dry tight": {"film": "none", "tolerance": 1e-7}}
cases["default"] = {"solver": {"model_tolerance_db": 0.05}}
cases |= {f"G {grade}": {"grade": grade} for grade in (1, 6.3, 16)}
cases |= {f"P_d {clearance}": {"clearance": clearance, "duration": 0.05} for clearance in CLEARANCES}
with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
    runs = dict(zip(cases, pool.map(lambda case: simulate(**case), cases.values())))

base = runs["base"]
default = runs["default"]
for channel in (Y, Z):
    apart, stated = abs(level(default, channel) - level(base, channel)), default["accuracy"]["level_error_db"]
    print(f"{channel}: {default['solver']['rung']} {apart:.4f} dB from full, {stated:.4f} stated")
    assert default["solver"]["rung"] == "radially_condensed" and apart < 0.05 and apart < 3 * stated
assert abs(base["kinematics"]["cage_speed_hz"] / 327.6 - 1) < 0.01, base["kinematics"]
strongest = max((x for x in base["lines"] if x["channel"] == Z), key=lambda x: x["amplitude"])
assert strongest["label"] == "BPFO" and abs(strongest["frequency_hz"] / 2293 - 1) < 0.01, strongest
assert all(line(base, Z, f"{k}·BPFO") > 0 for k in range(2, 9))
assert not any(line(base, channel, "f_r") for channel in (Y, Z)), "a balanced spindle shows f_r"
print(f"cage {base['kinematics']['cage_speed_hz']:.2f} Hz, {strongest['label']} {strongest['frequency_hz']:.1f} Hz strongest in z; no f_r")

shares = [line(runs[f"P_d {c}"], Y, "BPFO") for c in CLEARANCES]
for clearance, amplitude in zip(CLEARANCES, shares):
    twice = line(runs[f"P_d {clearance}"], Y, "2·BPFO")
    print(f"P_d {clearance:5} µm: y at BPFO {amplitude:7.3f} m/s², over 2·BPFO {amplitude / twice:.3f}")
least = shares.index(min(shares))
assert 3.25 <= CLEARANCES[least] <= 4.25
assert all(a > b for a, b in zip(shares[:least], shares[1:least + 1])), "more than one minimum"
assert all(a < b for a, b in zip(shares[least:], shares[least + 1:])), "more than one minimum"
assert shares[least] < 0.08 * line(runs[f"P_d {CLEARANCES[least]}"], Y, "2·BPFO")

per_grade = {grade: line(runs[f"G {grade}"], Z, "f_r") / grade for grade in (1, 6.3, 16)}
print("f_r over grade in z:", per_grade)
assert max(per_grade.values()) < 1.1 * min(per_grade.values())
unbalanced = {label: line(runs["G 6.3"], Z, label) for label in ("f_r", "BPFO + f_r", "BPFO − f_r")}
print("G 6.3, z:", unbalanced)
assert all(unbalanced.values()) and max(unbalanced, key=unbalanced.get) == "BPFO + f_r"

for channel in (Y, Z):
    apart = abs(level(base, channel) - level(runs["tight"], channel))
    print(f"{channel}: {apart:.1e} dB between relative tolerances 1e-5 and 1e-7")
    assert apart < 0.1
    a, b = runs["dry"], runs["dry tight"]
    apart, allowed = abs(level(a, channel) - level(b, channel)), 3 * (a["accuracy"]["level_error_db"] + b["accuracy"]["level_error_db"])
    print(f"{channel}, pocket film none: {apart:.3f} dB, allowed {allowed:.3f} dB")
    assert apart < max(0.1, allowed)
assert base["accuracy"]["motion"] == "decaying" and runs["dry"]["accuracy"]["motion"] == "diverging"
