#!/usr/bin/env python3
"""Lines that imperfect surfaces add to the motion of the spindle, against their formulas.

Usage: python3 benches/surfaces/lines.py --binary BINARY [--short] [--only TEXT] [--level TEXT] [--scene TEXT]

For each source (a wave, a defect, an uneven ball or pocket), each model level that carries it and each of four scenes, a run with the source
and one without it start alike. The spectrum of the difference of their displacements must show:

  there   every predicted line, at least 1 % as strong as the strongest that the source adds
  place   its frequency within 0.1 % of the formula at the simulated speeds of cage and balls
  others  no line above 1 % of the strongest, but lines of the ideal run and those that the general rule allows. Where there is one, both
          runs are repeated with the finest steps or tolerance, and the repetition counts: an integration error falls, a line stays
  labels  told, not judged: of the five strongest lines in the service's lists that the source adds, those without its label

`--short` takes one scene and the leanest level that represents it for each source. `--only`, `--level` and `--scene` take those whose names contain the text.

Definitions:
  Spectrum   y + i z of the difference under a Blackman-Harris window, whose side lobes are below 3e-5. 20 or more turns of the cage, 8192
             means over equal times. The line at f has both senses of rotation, as root of the sum of squares. Peaks are interpolated by
             a parabola through the logarithms of three entries.
  Line       a f_r + m FTF + s BSF with whole a, m, s. BPFO is Z FTF, BPFI is Z f_r - Z FTF.

Only the standard library is needed. The exit code is 1 if a check fails.
"""

import argparse
import cmath
import itertools
import json
import math
import os
import re
import subprocess
import sys
import tempfile

# Sampling rate of series [Hz], entries of a spectrum, and least number of cage turns in a record.
RATE, ENTRIES, TURNS = 102400, 8192, 20
# Half width of the window's main lobe [bins].
LOBE = 4
# Distance of a maximum from its line [bins]: neighbouring lines shift it.
REACH = 1
# Amplitude below which nothing is judged [nm]: rounding and integration errors of the runs.
FLOOR = 1e-3
# Least share of a line in the strongest one.
SHARE = 0.01
# Allowed relative deviation of a frequency.
DEVIATION = 1e-3
# Solver settings of a repetition: the finest steps of the reduced levels, and a tolerance near rounding.
FINEST = {level: {"fixed_step_us": 0.2} for level in ("radially_condensed", "spindle_only")} | {
    level: {"relative_tolerance": 1e-9} for level in ("full", "planar")} | {"periodic": {}}
# Highest orders of shaft and cage in a line. An inner defect is a sum of waves of all orders: up to these orders of shaft and ball passage every
# line is its own, beyond them those with sidebands of the shaft up to this order.
HIGHEST, WAVES, PASSAGES, SIDEBANDS = 200, 40, 8, 4
AXES = ("y", "z")

# A preload without load and weight, clearance under a load, and other sizes, numbers of balls, speeds and loads.
SCENES = {
    "preloaded": {"bearing": {"preset": "article-integrated", "radial_clearance_um": -4}, "gravity_m_s2": 0,
                  "operation": {"speed_rpm": 20000}},
    "loaded": {"bearing": {"preset": "article-integrated", "radial_clearance_um": 5},
               "operation": {"speed_rpm": 15000, "radial_load_y_n": 200}},
    "motor": {"bearing": {"preset": "6205"}, "operation": {"speed_rpm": 9000, "radial_load_y_n": 500}},
    "small": {"bearing": {"preset": "608", "radial_clearance_um": -3}, "operation": {"speed_rpm": 24000, "radial_load_y_n": 20}},
}
# Contact angles, by which waves of a groove's place push the spindle aside. A tilted shaft loads the balls unevenly.
INCLINED = {
    "thrust": {"bearing": {"preset": "6205"}, "operation": {"speed_rpm": 9000, "axial_load_n": 500}, "spindle": {"axial": "free"}},
    "tilted": {"bearing": {"preset": "6205"}, "spindle": {"axial": "free"},
               "operation": {"speed_rpm": 9000, "axial_load_n": 500, "misalignment_mrad": {"y": 1}}},
}
# Nothing moves without load, and the level `periodic` resolves no level of silence.
SILENT, INSTEAD = "preloaded", {"bearing": {"preset": "article-integrated", "radial_clearance_um": -4},
                                "operation": {"speed_rpm": 20000, "radial_load_y_n": 50}}
LEVELS = ("full", "planar", "radially_condensed", "spindle_only", "periodic")


class Source:
    """An imperfection: its fields, its lines (a, m, s) that must be there, and whether a line is one of the general rule."""

    def __init__(self, name, levels, surfaces=None, pockets=None, even_balls=False, needed=None, allowed=None, scenes=None):
        self.name, self.levels, self.even_balls, self.scenes = name, levels, even_balls, scenes or SCENES
        self.surfaces, self.pockets, self.needed, self.allowed = surfaces, pockets, needed, allowed


def wave(order):
    return {"waviness": [{"order": order, "amplitude_nm": 10, "phase_deg": 20}]}


def axial_wave(order):
    return {"axial_waviness": [{"order": order, "amplitude_nm": 100, "phase_deg": 20}]}


def slot(**fields):
    return {"defects": [{"azimuth_deg": 0, "length_mm": 0.3, "depth_um": 1, **fields}]}


def harmonics(step, names):
    return [(0, step * q, 0) for q in names]


def passes(z, order):
    """Lines of an inner wave: |q BPFO - n f_r|; under an even load only those of a rigid shift."""
    return lambda a, m, s: s == 0 and m % z == 0 and abs(a) == order


def sources():
    multiples = lambda z: lambda a, m, s: a == 0 and s == 0 and m % z == 0
    any_cage = lambda z: lambda a, m, s: a == 0 and s == 0
    found = []
    for name, order in (("Z - 1", lambda z: z - 1), ("2 Z + 1", lambda z: 2 * z + 1)):
        q = 1 if name == "Z - 1" else 2
        found.append(Source(
            f"outer wave {name}", LEVELS, lambda z, order=order: {"outer": wave(order(z))},
            needed=lambda z, even, q=q: [(0, q * z, 0)], allowed=multiples))
    found.append(Source("outer wave Z", LEVELS, lambda z: {"outer": wave(z)},
                        needed=lambda z, even: [] if even else [(0, z, 0)], allowed=multiples))
    found.append(Source("outer wave 3", LEVELS, lambda z: {"outer": wave(3)},
                        needed=lambda z, even: [] if even else [(0, z, 0)], allowed=multiples))
    for name, order, sign in (("Z - 1", lambda z: z - 1, 1), ("Z + 1", lambda z: z + 1, -1)):
        found.append(Source(
            f"inner wave {name}", LEVELS[:4], lambda z, order=order: {"inner": wave(order(z))},
            needed=lambda z, even, order=order: [(order(z), -z, 0)], allowed=lambda z, order=order: passes(z, order(z))))
    found.append(Source("inner wave Z", LEVELS[:4], lambda z: {"inner": wave(z)},
                        needed=lambda z, even: [] if even else [(z, -z, 0)], allowed=lambda z: passes(z, z)))
    found.append(Source("inner wave 2", LEVELS[:4], lambda z: {"inner": wave(2)},
                        needed=lambda z, even: [] if even else [(2, 0, 0)], allowed=lambda z: passes(z, 2)))
    larger = lambda ball: {"ball": ball, "diameter_um": 0.05}
    found.append(Source("off-size ball", LEVELS[:4], lambda z: {"balls": [larger(3)]},
                        needed=lambda z, even: [(0, 1, 0)], allowed=any_cage))
    found.append(Source("two opposite balls", LEVELS[:4], lambda z: {"balls": [larger(1), larger(1 + z // 2)]}, even_balls=True,
                        needed=lambda z, even: [] if even else [(0, 2, 0)],
                        allowed=lambda z: lambda a, m, s: a == 0 and s == 0 and m % 2 == 0))
    found.append(Source("pocket spacing", LEVELS[:4], pockets=lambda z: [0, 0, 10] + [0] * (z - 3),
                        needed=lambda z, even: [(0, 1, 0)], allowed=any_cage))
    found.append(Source("outer defect", LEVELS[:3], lambda z: {"outer": slot()},
                        needed=lambda z, even: harmonics(z, (1, 2, 3)), allowed=multiples))
    # The load zone modulates the passages of a defect that turns with the shaft, by every multiple of the shaft speed.
    found.append(Source("inner defect", LEVELS[:3], lambda z: {"inner": slot()},
                        needed=lambda z, even: [(z - 1, -z, 0), (z + 1, -z, 0)] + ([] if even else [(z, -z, 0)]),
                        allowed=lambda z: lambda a, m, s: s == 0 and m % z == 0 and (
                            abs(a) <= WAVES and abs(m) <= PASSAGES * z or abs(abs(a) - abs(m)) <= SIDEBANDS)))
    ball = lambda **fields: lambda z: {"balls": [{"ball": 3, **fields}]}
    for order in (2, 4):
        found.append(Source(f"ball wave {order}", LEVELS[:4], ball(**wave(order)),
                            needed=lambda z, even, order=order: [(0, 1, order), (0, -1, order)],
                            allowed=lambda z, order=order: lambda a, m, s: a == 0 and abs(s) in (0, order)))
    found.append(Source("ball wave 3", LEVELS[:4], ball(**wave(3)), needed=lambda z, even: [],
                        allowed=lambda z: lambda a, m, s: a == 0 and abs(s) in (0, 3, 6)))
    found.append(Source("ball defect", LEVELS[:2], ball(defects=[{"diameter_mm": 0.4, "depth_um": 2}]),
                        needed=lambda z, even: [(0, 1, 2), (0, -1, 2)], allowed=lambda z: lambda a, m, s: a == 0))
    # Of bearings with contact angles, on the level that knows them.
    for name, of in (("axial wave", axial_wave), ("wave, inclined,", wave)):
        found.append(Source(f"outer {name} Z + 1", LEVELS[:1], lambda z, of=of: {"outer": of(z + 1)}, scenes=INCLINED,
                            needed=lambda z, even: [(0, z, 0)], allowed=multiples))
        found.append(Source(f"inner {name} Z - 1", LEVELS[:1], lambda z, of=of: {"inner": of(z - 1)}, scenes=INCLINED,
                            needed=lambda z, even: [(z - 1, -z, 0)], allowed=lambda z: passes(z, z - 1)))
    return found


def transform(values):
    """Fourier transform of a power of two of complex values."""
    n = len(values)
    if n == 1:
        return list(values)
    even, odd = transform(values[::2]), transform(values[1::2])
    turned = [cmath.exp(-2j * math.pi * k / n) * value for k, value in enumerate(odd)]
    return [a + b for a, b in zip(even, turned)] + [a - b for a, b in zip(even, turned)]


WINDOW = [0.35875 - 0.48829 * math.cos(t) + 0.14128 * math.cos(2 * t) - 0.01168 * math.cos(3 * t)
          for t in (2 * math.pi * (i + 0.5) / ENTRIES for i in range(ENTRIES))]


def spectrum(motion):
    """Amplitude of y + i z, both senses of rotation together; the mean removed."""
    mean = sum(motion) / ENTRIES
    bins = transform([(value - mean) * weight for value, weight in zip(motion, WINDOW)])
    scale = math.sqrt(2) / sum(WINDOW)
    return [scale * math.hypot(abs(bins[k]), abs(bins[-k])) for k in range(ENTRIES // 2)]


def peak(entries, at):
    """Place of a local maximum in bins, and its height."""
    left, here, right = (math.log(max(entries[k], 1e-300)) for k in (at - 1, at, at + 1))
    curve = left - 2 * here + right
    off = 0.5 * (left - right) / curve if curve < 0 else 0.0
    return at + off, math.exp(here - 0.25 * (left - right) * off)


class Run:
    def __init__(self, binary, job, stride):
        names = [f"spindle.{axis}.displacement" for axis in AXES]
        with tempfile.TemporaryDirectory() as directory:
            done = subprocess.run([binary, "simulate", "-", "--quiet", "--output", directory], input=json.dumps(job), text=True,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False)
            self.refusal = done.stderr.strip() if done.returncode else ""
            if self.refusal:
                return
            y, z = (self.series(os.path.join(directory, f"series.{name}.csv"), stride) for name in names)
            with open(os.path.join(directory, "metrics.json"), encoding="utf-8") as metrics:
                answer = json.load(metrics)
        self.motion = [complex(*pair) for pair in zip(y, z)]
        self.metrics = answer.get("metrics", answer)

    @staticmethod
    def series(path, stride):
        """Means over `stride` samples [nm]."""
        with open(path, encoding="utf-8") as lines:
            next(lines)
            values = [1000 * float(line.split(",")[1]) for line in lines]
        return [sum(values[stride * i:stride * (i + 1)]) / stride for i in range(ENTRIES)]


def balls_of(scene):
    return scene["bearing"].get("ball_count") or {"6205": 9}.get(scene["bearing"]["preset"], 7)


def job_of(scene, level, stride, solver):
    channels = [f"spindle.{axis}.displacement" for axis in AXES]
    return {"kind": "simulation", "scene": scene, "settle_s": 0.15, "duration_s": (stride * ENTRIES + 1) / RATE, "solver": {"rung": level, **solver},
            "outputs": {"metrics": ["vibration"], "series": channels,
                        "spectra": channels + [f"spindle.{axis}.acceleration" for axis in AXES]}}


def parsed(label, z):
    """Whole numbers (a, m, s) of a label; none for a whirl or without a label."""
    if not label:
        return None
    vectors = {"f_r": (1, 0, 0), "FTF": (0, 1, 0), "BPFO": (0, z, 0), "BPFI": (z, -z, 0), "BSF": (0, 0, 1)}
    total, sign = (0, 0, 0), 1
    for word in re.sub("([+−])", r" \1 ", label).split():
        if word in "+−":
            sign = 1 if word == "+" else -1
            continue
        order, _, name = word.rpartition("·")
        if name not in vectors:
            return None
        total = tuple(t + sign * int(order or 1) * v for t, v in zip(total, vectors[name]))
    return total


def written(line, z):
    a, m, s = line
    parts = [(a, "f_r"), (m, "FTF"), (s, "BSF")] if m % z or s else [(a, "f_r"), (m // z, "BPFO")]
    text = " + ".join(name if order == 1 else f"{order}·{name}" for order, name in parts if order)
    return text.replace("+ -", "− ")


def wrong_labels(run, ideal, allowed, z, is_defect):
    """Of the five strongest listed lines of each channel that the source adds, those whose label is no line of the source. Envelopes are those
    of defects; that of a few waves has the differences of any two."""
    wrong = []
    kinds = ["lines", "envelope_lines"] if is_defect else ["lines"]
    for kind in kinds:
        listed, before = (one.metrics.get(kind, []) for one in (run, ideal))
        for channel in sorted({line["channel"] for line in listed}):
            old = [line for line in before if line["channel"] == channel]
            near = lambda line: max((o["amplitude"] for o in old if abs(o["frequency_hz"] / line["frequency_hz"] - 1) < DEVIATION), default=0)
            of_channel = [line for line in listed if line["channel"] == channel]
            new = [line for line in of_channel if line["amplitude"] > max(2 * near(line), SHARE * of_channel[0]["amplitude"])][:5]
            for line in new:
                vector = parsed(line["label"], z)
                if vector is None or not allowed(*vector):
                    wrong.append(f"{channel[8:]} {kind}: {line['label'] or 'none'} at {line['frequency_hz']:.2f} Hz")
    return wrong


def judged(source, scene, run, ideal):
    """A row of the table, and whether line, place and others hold."""
    z, even = balls_of(scene), scene.get("gravity_m_s2") == 0 and not scene["operation"].get("radial_load_y_n")
    simulated = run.metrics["frequencies_hz"]
    speeds = (simulated["shaft"], simulated["cage"], simulated["ball_spin"])
    frequency = lambda line: abs(sum(order * speed for order, speed in zip(line, speeds)))
    duration = len(run.motion) * run.step
    entries = spectrum([a - b for a, b in zip(run.motion, ideal.motion)])
    before = ideal.entries
    for k in range(LOBE):
        entries[k] = 0.0
    is_allowed = source.allowed(z)
    rule = lambda *line: is_allowed(*line) or line[0] == line[2] == 0 and line[1] % z == 0
    strongest = max(entries)
    allowed = [False] * len(entries)
    orders = [range(-HIGHEST, HIGHEST + 1), range(-HIGHEST, HIGHEST + 1), range(0, 9)]
    for line in itertools.product(*orders):
        if rule(*line):
            at = frequency(line) * duration
            for k in range(max(0, round(at) - REACH), min(len(entries), round(at) + REACH + 1)):
                allowed[k] = True
    places, missing = [], []
    for line in source.needed(z, even):
        at = frequency(line) * duration
        middle = max(range(max(1, round(at) - 2), round(at) + 3), key=lambda k: entries[k])
        place, height = peak(entries, middle)
        if height < SHARE * strongest:
            missing.append(f"{written(line, z)} {height / strongest:.4f}")
        else:
            places.append((abs(place / at - 1), written(line, z), height))
    # Two irregular motions of one amplitude differ by at most twice that.
    others = [(e / strongest, k / duration) for k, e in enumerate(entries[:-1])
              if e > max(SHARE * strongest, FLOOR) and not allowed[k] and entries[k - 1] <= e >= entries[k + 1]
              and 2 * max(before[k - LOBE:k + LOBE + 1]) < e]
    others.sort(reverse=True)
    worst = max(places, default=(0, "", 0))
    wrong = wrong_labels(run, ideal, rule, z, "defect" in source.name)
    slip = simulated["cage"] / ideal.metrics["frequencies_hz"]["cage"] - 1
    holds = not missing and worst[0] <= DEVIATION and not others
    return {"holds": holds, "strongest": strongest, "at": entries.index(strongest) / duration,
            "lines": [(name, height) for _, name, height in places], "deviation": worst[0], "missing": missing,
            "others": [f"{at:.1f} Hz {share:.3f}" for share, at in others[:4]], "labels": wrong, "cage": slip,
            "allowed": sum(allowed) / len(allowed)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--short", action="store_true")
    parser.add_argument("--only", default="")
    parser.add_argument("--level", default="")
    parser.add_argument("--scene", default="")
    options = parser.parse_args()
    ideals, failed = {}, 0
    wanted = [source for source in sources() if options.only in source.name]
    # One scene of every source comes before the second of any.
    for turn, (number, source) in itertools.product(range(1 if options.short else len(SCENES)), enumerate(wanted)):
        for level in source.levels[::-1] if options.short else source.levels:
            name = list(source.scenes)[(number + turn) % len(source.scenes)]
            if turn >= len(source.scenes) or options.level not in level or options.scene not in name:
                continue
            scene = json.loads(json.dumps(INSTEAD if (level, name) == ("periodic", SILENT) else source.scenes[name]))
            if source.even_balls:
                scene["bearing"]["ball_count"] = balls_of(scene) // 2 * 2
            z = balls_of(scene)
            # The cage turns at some 0.39 of the shaft speed.
            stride = math.ceil(TURNS / (0.39 * scene["operation"]["speed_rpm"] / 60) * RATE / ENTRIES)
            wavy = json.loads(json.dumps(scene))
            if source.surfaces:
                wavy["surfaces"] = source.surfaces(z)
            if source.pockets:
                wavy["bearing"]["cage"] = {"pocket_spacing_mrad": source.pockets(z)}

            def row_with(solver):
                """The row of runs with solver settings, or why one was refused."""
                key = json.dumps([scene, level, solver])
                if key not in ideals:
                    ideals[key] = Run(options.binary, job_of(scene, level, stride, solver), stride)
                    if not ideals[key].refusal:
                        ideals[key].entries = spectrum(ideals[key].motion)
                run = Run(options.binary, job_of(wavy, level, stride, solver), stride)
                if run.refusal or ideals[key].refusal:
                    return run.refusal or ideals[key].refusal
                run.step = stride / RATE
                return judged(source, wavy, run, ideals[key])

            row = row_with({})
            coarse = row["others"] if isinstance(row, dict) else []
            if coarse:
                row = row_with(FINEST[level])
            if isinstance(row, str):
                print(f"{source.name:20} {level:18} {name:10} refused: {row[-200:]}", flush=True)
                continue
            failed += not row["holds"]
            lines = ", ".join(f"{line} {height:.3g}" for line, height in row["lines"])
            print(f"{source.name:20} {level:18} {name:10} {'ok    ' if row['holds'] else 'FAILED'} strongest {row['strongest']:.3g} nm at {row['at']:.0f} Hz; "
                  f"{lines}; off {row['deviation']:.1e}; missing {row['missing']}; others {row['others']}; with the default steps {coarse}; labels {row['labels'][:4]}; "
                  f"cage {row['cage']:.1e}; allowed {row['allowed']:.2f}", flush=True)
            if options.short:
                break
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
