#!/usr/bin/env python3
"""Levels of imperfect surfaces on radially_condensed against full, over drawn scenes.

Usage: python3 benches/surfaces/levels.py --binary BINARY --rows FILE [--count 60] [--from 0] [--limit 120] [--kind waves|defect]
       [--report] [--csv FILE]

Each scene is one of benches/calibration/drawn.rs with drawn surfaces and, in every second one, a cage that is symmetric like those of two
ribbons. It runs twice: kind `waves` has waves of raceways or balls, often with unequal balls and pockets, and kind `defect` has a defect of
a raceway, too. What is admitted also runs on `full`. A later call with the same file of rows (JSON lines) computes only the missing ones and
those without a reference. `--report` prints the table from the rows without a run; `--csv` also writes them as a file for docs/data.

  admitted   the selected level `radially_condensed` runs and its verification confirms it; all else is refused or carries a warning
  within     accelerations y and z within 0.05 dB of `full` with waves, within 0.2 dB with a defect; there, the first three envelope lines
             along y that `full` lists within 0.5 dB
  miss       admitted, not within, and without a warning

Only the standard library is needed. The exit code is 1 after a miss.
"""

import argparse
import csv
import datetime
import itertools
import json
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, "compare"))
import compare  # noqa: E402

KINDS = ("waves", "defect")
CHANNELS = ("spindle.y.acceleration", "spindle.z.acceleration")
# Ball diameters [mm] and numbers of balls of the drawn bearings.
BEARINGS = {"article-integrated": (2.778, 7), "article-deep-groove": (2.38, 7), "608": (3.969, 7), "6205": (7.94, 9)}
SYMMETRIC = {"seat": "closed", "offset_mm": 0}
# Allowed deviations of levels and of envelope lines [dB].
LEVEL_DB = {"waves": 0.05, "defect": 0.2}
ENVELOPE_DB = 0.5
# Settling time and least recorded time [s], cage turns in it, and least cage speed over shaft speed.
SETTLE, LEAST, TURNS, CAGE = 0.1, 0.2, 10, 0.37
NOT_CONFIRMED = ("model-not-confirmed", "error-unknown")


class Draw(compare.Draw):
    """Draws of one scene, which depend on its index alone."""

    def surfaces(self, scene):
        """Waves of at least one surface, unequal balls and pockets."""
        first = self.one_of(("inner", "outer", "balls"))
        has = lambda kind: kind == first or self.chance(0.5)
        surfaces = {ring: {"random_waviness": {"amplitude_nm": self.between_decades(1.0, 30.0)}} for ring in ("inner", "outer") if has(ring)}
        every = {"random_waviness": {"amplitude_nm": self.between_decades(0.3, 5.0)}} if has("balls") else {}
        if self.chance(0.5):
            every["diameter_spread_um"] = self.between_decades(0.02, 0.5)
        if every:
            surfaces["every_ball"] = every
        cage = dict(SYMMETRIC) if self.chance(0.5) else {}
        if self.chance(0.3):
            balls = scene["bearing"].get("ball_count", BEARINGS[scene["bearing"]["preset"]][1])
            cage["pocket_spacing_mrad"] = [self.between_decades(0.1, 3.0)] + [0.0] * (balls - 1)
        if cage:
            scene["bearing"]["cage"] = cage
        scene["surfaces"] = surfaces

    def defect(self, scene):
        """A defect of a raceway; an outer one within 30° of the load."""
        operation, (ball, _) = scene["operation"], BEARINGS[scene["bearing"]["preset"]]
        load = math.degrees(math.atan2(operation.get("radial_load_z_n", 0.0), operation["radial_load_y_n"]))
        defect = {"azimuth_deg": round(load + self.between(-30, 30), 1), "depth_um": self.between_decades(0.5, 20.0),
                  "length_mm": float(f"{ball * self.between_decades(0.02, 0.25):.3g}"), "shape": self.one_of(("rectangular", "half_sine"))}
        scene["surfaces"].setdefault(self.one_of(("inner", "outer")), {})["defects"] = [defect]


def job(index, kind):
    draw = Draw(1_000_003 * (index + 1))
    scene = draw.scene()
    draw.surfaces(scene)
    if kind == "defect":
        draw.defect(scene)
    turn = 60 / (CAGE * scene["operation"]["speed_rpm"])
    return {"kind": "simulation", "scene": scene, "settle_s": SETTLE, "duration_s": float(f"{max(LEAST, TURNS * turn):.3g}"),
            "outputs": {"metrics": ["vibration"], "spectra": list(CHANNELS)}}


def decibels(value, reference):
    return 20 * math.log10(value / reference)


def envelope_errors(found, full):
    """Deviations of the first three lines of the envelope along y [dB]; infinite for a line that is not listed."""
    lines = lambda metrics: [line for line in metrics.get("envelope_lines", []) if line["channel"] == CHANNELS[0]]
    errors = []
    for line in lines(full)[:3]:
        same = [other for other in lines(found) if abs(other["frequency_hz"] / line["frequency_hz"] - 1) < 1e-2]
        errors.append(min((decibels(other["amplitude"], line["amplitude"]) for other in same), key=abs, default=math.inf))
    return errors


def row_of(index, kind, runner, binary):
    drawn = job(index, kind)
    scene = drawn["scene"]
    row = {"index": index, "kind": kind, "bearing": scene["bearing"]["preset"], "speed_rpm": scene["operation"]["speed_rpm"],
           "radial_load_n": round(math.hypot(scene["operation"]["radial_load_y_n"], scene["operation"].get("radial_load_z_n", 0.0)), 1),
           "symmetric": "seat" in scene["bearing"].get("cage", {}), "surfaces": scene["surfaces"]}
    run = lambda level: runner.run(binary, "simulate", drawn | {"solver": {"rung": level}})
    done = run("radially_condensed")
    row["cpu_s"] = done["cpu_s"]
    if "failure" in done:
        return row | {"outcome": "refused", "reason": done["failure"]}
    found = json.loads(done["answer"])
    warned = [message["code"] for message in found["messages"] if message["severity"] != "info"]
    doubts = [message["text"] for message in found["messages"] if message["code"] in NOT_CONFIRMED]
    if doubts:
        return row | {"outcome": "not confirmed", "reason": doubts[0]}
    done = run("full")
    row["cpu_s_full"] = done["cpu_s"]
    if "failure" in done:
        return row | {"outcome": "no reference", "reason": done["failure"]}
    full = json.loads(done["answer"])
    level = lambda metrics, channel: metrics["channels"][channel]["level_db"]
    errors = [level(found, channel) - level(full, channel) for channel in CHANNELS]
    of_lines = envelope_errors(found, full) if kind == "defect" else []
    within = all(abs(error) <= LEVEL_DB[kind] for error in errors) and all(abs(error) <= ENVELOPE_DB for error in of_lines)
    stated = lambda metrics: max(metrics["channels"][channel].get("level_error_db") or math.inf for channel in CHANNELS)
    return row | {"outcome": "admitted", "within": within, "warnings": warned, "errors_db": errors, "envelope_errors_db": of_lines,
                  "stated_db": stated(found), "reference_error_db": stated(full)}


def largest(rows, name):
    return max((abs(error) for row in rows for error in row[name]), default=0.0)


def report(rows):
    """Prints the table and returns the number of misses."""
    heads = ("surfaces", "cage", "scenes", "admitted", "within", "largest error of a level [dB]", "of an envelope line [dB]", "not confirmed",
             "refused", "no reference", "misses")
    print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
    misses = 0
    for kind, symmetric in itertools.product(KINDS, (True, False)):
        of_kind = [row for row in rows if row["kind"] == kind and row["symmetric"] == symmetric]
        admitted, doubted, refused, unknown = ([row for row in of_kind if row["outcome"] == name]
                                               for name in ("admitted", "not confirmed", "refused", "no reference"))
        missed = [row for row in admitted if not row["within"] and not row["warnings"]]
        misses += len(missed)
        envelope = f"{largest(admitted, 'envelope_errors_db'):.3f}" if kind == "defect" else ""
        entries = (kind, "symmetric" if symmetric else "crown", len(of_kind), len(admitted), sum(row["within"] for row in admitted),
                   f"{largest(admitted, 'errors_db'):.3f}", envelope, len(doubted), len(refused), len(unknown), len(missed))
        print(f"| {' | '.join(str(entry) for entry in entries)} |")
    for row in rows:
        if row["outcome"] == "admitted" and not row["within"]:
            print({key: row[key] for key in row if key != "surfaces"}, file=sys.stderr)
    return misses


def write_csv(rows, path):
    written = lambda row, name: [f"{error:.4f}" for error in row.get(name, [])]
    padded = lambda entries, count: entries + [""] * (count - len(entries))
    with open(path, "w", encoding="utf-8", newline="") as file:
        file.write("# Levels on radially_condensed less those on full, where it is admitted: drawn scenes with waves, and with a defect too.\n"
                   "# command: python3 benches/surfaces/levels.py --binary target/release/raceway --rows ROWS --csv docs/data/surface-levels.csv\n"
                   f"# date: {datetime.date.today()}\n# machine: any; errors and counts do not depend on it\n"
                   "# envelope_1 to 3: the first three lines of the envelope of a_y that full lists; no reference: full took more than --limit\n")
        table = csv.writer(file, lineterminator="\n")
        table.writerow(("index", "surfaces", "bearing", "cage", "speed_rpm", "radial_load_n", "outcome", "error_ay_db", "error_az_db",
                        "envelope_1_db", "envelope_2_db", "envelope_3_db", "stated_db", "reference_db"))
        for row in sorted(rows, key=lambda row: (KINDS.index(row["kind"]), row["index"])):
            outcome = row["outcome"] if row["outcome"] != "admitted" else "within" if row["within"] else "beyond"
            stated = [f"{row[name]:.4f}" for name in ("stated_db", "reference_error_db") if name in row]
            table.writerow((row["index"], row["kind"], row["bearing"], "symmetric" if row["symmetric"] else "crown", row["speed_rpm"],
                            row["radial_load_n"], outcome, *padded(written(row, "errors_db"), 2), *padded(written(row, "envelope_errors_db"), 3),
                            *padded(stated, 2)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary")
    parser.add_argument("--rows", required=True)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--from", type=int, default=0, dest="first")
    parser.add_argument("--limit", type=float, default=120.0)
    parser.add_argument("--kind", choices=KINDS)
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--csv")
    options = parser.parse_args()
    rows = {(row["index"], row["kind"]): row for row in compare.read_lines(options.rows)}
    runner = compare.Runner(timeout=60 * options.limit)
    runner.cpu_limit = options.limit
    for kind, index in itertools.product([options.kind] if options.kind else KINDS, range(options.first, options.first + options.count)):
        if options.report or rows.get((index, kind), {}).get("outcome", "no reference") != "no reference":
            continue
        row = rows[index, kind] = row_of(index, kind, runner, options.binary)
        compare.append(options.rows, row)
        compare.progress(json.dumps({key: value for key, value in row.items() if key != "surfaces"}))
    rows = list(rows.values())
    if options.csv:
        write_csv(rows, options.csv)
    sys.exit(1 if report(rows) else 0)


if __name__ == "__main__":
    main()
