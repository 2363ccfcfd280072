#!/usr/bin/env python3
"""Predictions beside measured vibration of bearings with faults of a raceway.

Usage (python3 benches/measured/measured.py MODE …):

  facts FILE --fault inner|outer [--shaft HZ --balls 8 --ball-mm 5.969 --pitch-mm 31.623]
      Facts of a record: statistics, and lines of its envelope over the line of the fault. FILE may be compressed by gzip. Its
      first line holds `sampling rate [Hz]: …; scale [g per count]: …`; then follows one whole number a line.
  predict --binary BINARY [--length-mm 1] [--depth-um 50] [--duration 3]
      The same facts of simulations of that bearing with a fault of the inner ring (445 N) and of the outer ring (1334 N).

Definitions:
  Envelope   Magnitude of the analytic signal in the band 2 to 20 kHz, its mean removed, under a Hann window. Peaks are read
             as the largest entry within 0.4 % of a frequency, at the place of the fault's strongest harmonic.
  Ratio      Amplitude of a line over that of the fault's first line.

The records are not part of the repository, because their licence is not that of the program. Only the standard library is needed.
"""

import argparse
import cmath
import gzip
import json
import math
import os
import subprocess
import tempfile

BAND = (2000.0, 20000.0)
# Bearing of the records "NICE" of the Society for Machinery Failure Prevention Technology, and their shaft speed [Hz].
BALLS, BALL_MM, PITCH_MM, SHAFT = 8, 5.969, 31.623, 24.74
# Sampling rate of simulated signals [Hz].
RATE = 102400


def transform(values, sign=-1):
    """Fourier transform of a power of two of values (Cooley and Tukey)."""
    n = len(values)
    values = list(values)
    bits = n.bit_length() - 1
    for at in range(n):
        mirrored = int(f"{at:0{bits}b}"[::-1], 2)
        if at < mirrored:
            values[at], values[mirrored] = values[mirrored], values[at]
    half = 1
    while half < n:
        circle = [cmath.exp(sign * 1j * math.pi * k / half) for k in range(half)]
        for start in range(0, n, 2 * half):
            for k in range(half):
                a, b = values[start + k], circle[k] * values[start + k + half]
                values[start + k], values[start + k + half] = a + b, a - b
        half *= 2
    return values


def envelope(signal, rate):
    """Amplitude spectrum of the envelope, and its resolution [Hz]."""
    n = 1 << (len(signal).bit_length() - 1)
    bins = transform(signal[:n])
    inside = [2 * value if BAND[0] <= k * rate / n <= BAND[1] else 0 for k, value in enumerate(bins[:n // 2])]
    magnitude = [abs(value) / n for value in transform(inside + [0] * (n - n // 2), 1)]
    mean = sum(magnitude) / n
    windowed = [(value - mean) * (0.5 - 0.5 * math.cos(2 * math.pi * i / n)) for i, value in enumerate(magnitude)]
    return [4 * abs(value) / n for value in transform(windowed)[:n // 2]], rate / n


def peak(spectrum, resolution, frequency):
    """Frequency and amplitude of the largest entry near a frequency, interpolated."""
    reach = max(2, round(0.004 * frequency / resolution))
    middle = round(frequency / resolution)
    at = max(range(max(1, middle - reach), middle + reach + 1), key=lambda k: spectrum[k])
    left, here, right = spectrum[at - 1:at + 2]
    # Hann window: the ratio of the larger neighbour gives the place between the bins.
    side, step = (right, 1) if right > left else (left, -1)
    off = (2 * side - here) / (side + here) if here > 0 else 0.0
    return (at + step * off) * resolution, here


def statistics(signal):
    n = len(signal)
    mean = sum(signal) / n
    squares = [(value - mean) ** 2 for value in signal]
    variance = sum(squares) / n
    largest = max(squares) ** 0.5
    return variance ** 0.5, largest / variance ** 0.5, sum(s * s for s in squares) / n / variance ** 2


def facts(signal, rate, shaft, geometry, fault):
    balls, ball, pitch = geometry
    cage = shaft * (1 - ball / pitch) / 2
    line = balls * (shaft - cage) if fault == "inner" else balls * cage
    spectrum, resolution = envelope(signal, rate)
    found, amplitude = peak(spectrum, resolution, line)
    ratio = lambda frequency: peak(spectrum, resolution, frequency)[1] / amplitude
    rms, crest, kurtosis = statistics(signal)
    print(f"{fault}: line at {found:.2f} Hz, {found / shaft:.4f} f_r ({line / shaft:.4f} without slip); "
          f"f_r {ratio(shaft):.2f}; - f_r {ratio(found - shaft):.2f}, + f_r {ratio(found + shaft):.2f}; "
          f"2x {ratio(2 * found):.2f}, 3x {ratio(3 * found):.2f}, 4x {ratio(4 * found):.2f}; "
          f"kurtosis {kurtosis:.1f}, crest {crest:.1f}, rms {rms:.3g}")


def record(path):
    opened = gzip.open(path, "rt") if path.endswith(".gz") else open(path)
    with opened as lines:
        head = next(lines)
        rate, scale = (float(part.split(":")[1].split(";")[0]) for part in head.split(";", 1))
        return [scale * int(line) for line in lines], rate


def simulated(options, fault, load):
    """Acceleration [g] of the spindle along the load."""
    scene = {
        "bearing": {"outer_diameter_mm": 42, "inner_diameter_mm": 20, "width_mm": 12, "ball_count": BALLS,
                    "ball_diameter_mm": BALL_MM, "pitch_diameter_mm": PITCH_MM},
        "operation": {"speed_rpm": round(60 * SHAFT, 3), "radial_load_y_n": load},
        "surfaces": {fault: {"defects": [{"azimuth_deg": 0, "length_mm": options.length_mm, "depth_um": options.depth_um}]}}}
    channel = "spindle.y.acceleration"
    job = {"kind": "simulation", "scene": scene, "duration_s": options.duration,
           "outputs": {"metrics": ["vibration", "cage"], "series": [channel]}}
    with tempfile.TemporaryDirectory() as directory:
        subprocess.run([options.binary, "simulate", "-", "--quiet", "--output", directory], input=json.dumps(job), text=True,
                       stdout=subprocess.DEVNULL, check=True)
        with open(os.path.join(directory, f"series.{channel}.csv"), encoding="utf-8") as lines:
            next(lines)
            signal = [float(line.split(",")[1]) / 9.80665 for line in lines]
        with open(os.path.join(directory, "metrics.json"), encoding="utf-8") as metrics:
            answer = json.load(metrics)
    return signal, answer.get("metrics", answer)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest="mode", required=True)
    of_record = modes.add_parser("facts")
    of_record.add_argument("file")
    of_record.add_argument("--fault", choices=("inner", "outer"), required=True)
    of_record.add_argument("--shaft", type=float, default=SHAFT)
    of_record.add_argument("--balls", type=int, default=BALLS)
    of_record.add_argument("--ball-mm", type=float, default=BALL_MM)
    of_record.add_argument("--pitch-mm", type=float, default=PITCH_MM)
    predict = modes.add_parser("predict")
    predict.add_argument("--binary", required=True)
    predict.add_argument("--length-mm", type=float, default=1)
    predict.add_argument("--depth-um", type=float, default=50)
    predict.add_argument("--duration", type=float, default=3)
    options = parser.parse_args()
    if options.mode == "facts":
        signal, rate = record(options.file)
        facts(signal, rate, options.shaft, (options.balls, options.ball_mm, options.pitch_mm), options.fault)
        return
    for fault, load in (("inner", 445), ("outer", 1334)):
        signal, metrics = simulated(options, fault, load)
        facts(signal, RATE, SHAFT, (BALLS, BALL_MM, PITCH_MM), fault)
        slip = metrics["kinematics"]["cage_slip"]
        print(f"    cage slip {100 * slip:.3f} %, {metrics['solver']['rung']}, level error {metrics['accuracy'].get('level_error_db')} dB")


if __name__ == "__main__":
    main()
