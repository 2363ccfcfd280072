#!/usr/bin/env python3
"""Drawn machines whose bending or tilt could be left out by a bound from the linear analysis.

Usage: python3 benches/modes/omissions.py --binary BINARY [--seed 1] [--count 200]

Each machine of benches/coverage/machines.py is analysed as a `rotor`, with its own modulus and with the largest one that a job may have,
2000 GPa. The table counts machines by

  bending  the largest change of a natural frequency below 20 kHz by that stiffer shaft [-]; a rigid shaft changes it more. Modes are matched by
           their number, so that a mode that leaves the band counts as a change.
  tilt     the largest static tilt of an inner ring [mrad].

Only the standard library is needed.
"""

import argparse
import json
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, os.pardir, "compare"), os.path.join(HERE, os.pardir, "coverage")]
import compare  # noqa: E402
import machines  # noqa: E402

BAND_HZ, STIFFEST_GPA, STEEL_GPA, DENSITY = 20_000.0, 2000.0, 208.0, 7830.0


def analysed(runner, binary, scene, modulus):
    material = {"elastic_modulus_gpa": modulus, "poisson_ratio": 0.3, "density_kg_m3": DENSITY}
    scene = scene | {"shaft": scene["shaft"] | {"material": material}}
    found = runner.run(binary, "simulate", {"kind": "rotor", "scene": scene, "speeds_rpm": [0], "modes": 20})
    return None if "failure" in found else json.loads(found["answer"])


def frequencies(answer):
    return sorted(mode["frequency_hz"] for mode in answer["operating"]["modes"] if mode["frequency_hz"] < BAND_HZ)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=200)
    options = parser.parse_args()
    runner, changes, tilts, failed = compare.Runner(600.0), [], [], 0
    for index in range(options.count):
        scene = machines.drawn(options.seed, index)["scene"]
        pair = [analysed(runner, options.binary, scene, modulus) for modulus in (STEEL_GPA, STIFFEST_GPA)]
        if None in pair:
            failed += 1
            continue
        own, stiff = map(frequencies, pair)
        common = min(len(own), len(stiff))
        changes.append(max([abs(a / b - 1.0) for a, b in zip(own[:common], stiff[:common])] + [1.0] * (len(own) != len(stiff))))
        tilts.append(max(abs(tilt) for bearing in pair[0]["bearings"] for tilt in bearing["tilt_mrad"]))
    print(f"{len(changes)} machines analysed, {failed} without an equilibrium. Binary {compare.label_of(options.binary)}; {compare.now()}\n")
    for name, values, limits in (("bending", changes, (1e-3, 1e-2, 0.1)), ("tilt", tilts, (0.01, 0.1, 1.0))):
        counts = ", ".join(f"{sum(value < limit for value in values)} below {limit:g}" for limit in limits)
        print(f"{name}: {counts}; least {min(values):.3g}, median {sorted(values)[len(values) // 2]:.3g}")


if __name__ == "__main__":
    main()
