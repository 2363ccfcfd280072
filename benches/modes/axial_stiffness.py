#!/usr/bin/env python3
"""Axial stiffness of one angular-contact bearing in the full dynamics, from its answer to a small harmonic thrust.

Usage: python3 benches/modes/axial_stiffness.py --binary BINARY [--law coulomb]

A rigid spindle of 1 kg on a 7008 of 25° under 200 N of thrust, without weight. With the amplitude x of the displacement under a thrust F cos ωt
the stiffness is F/x + m ω². `coulomb`: traction with the coefficient 0.05 over 0.01 m/s in place of the default law. Only the standard library is
needed.
"""

import argparse
import json
import math
import subprocess

THRUST_N, AMPLITUDE_N, MASS_KG = 200.0, 0.2, 1.0
# Speed [r/min] and frequency of the thrust [Hz], below the resonance of the spindle.
CASES = ((5000, 100), (6000, 100), (6000, 450), (10000, 100))
COULOMB = {"traction": {"law": "coulomb", "coefficient": 0.05, "regularisation_m_s": 0.01}}


def stiffness(binary, rpm, frequency, lubricant, mass=MASS_KG):
    """[N/µm]"""
    bearing = {"type": "angular_contact", "outer_diameter_mm": 68, "inner_diameter_mm": 40, "width_mm": 15, "ball_count": 17,
               "ball_diameter_mm": 7.938, "pitch_diameter_mm": 54, "contact_angle_deg": 25}
    load = {"direction": "x", "harmonic": {"amplitude_n": AMPLITUDE_N, "frequency_hz": frequency}}
    scene = {"gravity_m_s2": 0, "bearing": bearing, "spindle": {"axial": "free", "mass_kg": mass},
             "operation": {"speed_rpm": rpm, "axial_load_n": THRUST_N, "loads": [load]}} | lubricant
    job = {"settle_s": 0.4, "duration_s": 0.1, "scene": scene, "solver": {"rung": "full"}}
    done = subprocess.run([binary, "simulate", "--quiet", "-"], input=json.dumps(job), capture_output=True, text=True, check=True)
    displaced = json.loads(done.stdout)["channels"]["spindle.x.displacement"]["rms"] * 1e-6 * math.sqrt(2.0)
    return 1e-6 * (AMPLITUDE_N / displaced + mass * (2.0 * math.pi * frequency) ** 2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--law", choices=("default", "coulomb"), default="default")
    asked = parser.parse_args()
    lubricant = {"lubricant": {"kind": "grease"} | COULOMB} if asked.law == "coulomb" else {}
    for rpm, frequency in CASES:
        print(f"{rpm} r/min, {frequency} Hz: {stiffness(asked.binary, rpm, frequency, lubricant):.2f} N/µm", flush=True)
    # A light spindle stays below its resonance at this frequency.
    print(f"6000 r/min, 900 Hz: {stiffness(asked.binary, 6000, 900, lubricant, mass=0.1):.2f} N/µm")


if __name__ == "__main__":
    main()
