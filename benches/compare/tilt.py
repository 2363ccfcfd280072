#!/usr/bin/env python3
"""Scenes whose balls leave the plane a little: which model level is accepted, is its level right, and what does it cost?

Usage: python3 benches/compare/tilt.py --binary BINARY [--other BINARY] [--seed 1] [--count 60]

Scenes are drawn where the seat of a crown cage tilts it: 1500 to 12 000 r/min, 15 to 800 N. Each runs 1 s with vibration as output, once as a
plain job and once on `full`. A level is wrong where it differs from that of `full` by more than three times what both state, and by more than
0.002 dB, without a warning. `--other`: the same jobs by another build, in turns; its `full` is not run again.

Only the standard library is needed. The exit code is 1 if more than one level in a hundred is wrong.
"""

import argparse
import json
import random
import resource
import subprocess
import sys

CHANNELS = ("spindle.y.acceleration", "spindle.z.acceleration")
# Vibration of the start, which both runs share.
TRANSIENTS = {"start-transient", "cage-transient", "tilt-transient"}


def drawn(draw):
    """A scene."""
    decades = lambda low, high: low * (high / low) ** draw.random()
    bearing = {"preset": draw.choice(["article-integrated", "article-deep-groove", "608", "6205", "6205"])}
    if draw.random() < 0.6:
        bearing["radial_clearance_um"] = round(decades(1, 40), 3)
    if draw.random() < 0.3:
        bearing["cage"] = {"mass_g": round(decades(0.1, 10), 3), "offset_mm": round(decades(0.1, 4), 3)}
    scene = {"bearing": bearing, "operation": {"speed_rpm": round(decades(1500, 12000)), "radial_load_y_n": round(decades(15, 800), 1)}}
    if draw.random() < 0.5:
        scene["spindle"] = {"mass_kg": round(decades(0.02, 2), 3)}
    if draw.random() < 0.3:
        scene["surfaces"] = {ring: {"random_waviness": {"amplitude_nm": round(decades(1, 50), 2), "at_order": 10}} for ring in ("inner", "outer")}
    return scene


def run(binary, scene, solver):
    """Answer and processor time; none where the job fails."""
    job = {"kind": "simulation", "scene": scene, "duration_s": 1, "solver": solver, "outputs": {"metrics": ["vibration"]}}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([binary, "simulate", "-", "--quiet"], input=json.dumps(job), text=True, capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (json.loads(done.stdout) if done.returncode == 0 else None), after.ru_utime - before.ru_utime


def wrong(answer, full):
    """Levels that are off by more than stated, without a warning: channel, error, stated."""
    if {message["code"] for message in answer["messages"] if message["severity"] != "info"} - TRANSIENTS:
        return []
    found = []
    for channel in CHANNELS:
        own, reference = answer["channels"][channel], full["channels"][channel]
        stated = own.get("level_error_db")
        error = own["level_db"] - reference["level_db"]
        if stated is not None and abs(error) > max(3 * (stated + (reference.get("level_error_db") or 0)), 2e-3):
            found.append((channel, error, stated))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--other")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    options = parser.parse_args()
    binaries = [binary for binary in (options.binary, options.other) if binary]
    draw = random.Random(options.seed)
    rows = {binary: {"levels": {}, "wrong": 0, "time": 0.0, "warned": 0} for binary in binaries}
    jobs = 0
    for index in range(options.count):
        scene = drawn(draw)
        full, _ = run(options.binary, scene, {"rung": "full"})
        answers = [run(binary, scene, {}) for binary in binaries]
        if full is None or any(answer is None for answer, _ in answers):
            continue
        jobs += 1
        for binary, (answer, time) in zip(binaries, answers):
            row, level = rows[binary], answer["solver"]["rung"]
            row["levels"][level] = row["levels"].get(level, 0) + 1
            row["time"] += time
            row["warned"] += any(message["severity"] != "info" for message in answer["messages"])
            for channel, error, stated in wrong(answer, full):
                row["wrong"] += 1
                print(f"{index}: {binary} {level} {channel} off by {error:.3f} dB, {stated:.4f} stated: {json.dumps(scene)}", flush=True)
    for binary, row in rows.items():
        print(f"{binary}: {jobs} jobs, levels {row['levels']}, {row['warned']} with a warning, {row['wrong']} of {2 * jobs} levels wrong, "
              f"{row['time']:.1f} s of processor time")
    sys.exit(rows[options.binary]["wrong"] > 0.01 * 2 * jobs)


if __name__ == "__main__":
    main()
