#!/usr/bin/env python3
"""Do the stated errors of machines cover the true ones? Drawn shafts on ball bearings, each beside finer steps and more modes.

Usage (python3 benches/coverage/machines.py MODE …):

  run --binary BINARY --rows FILE [--seed 1] [--from 0] [--count 40] [--limit 60] [--nice N] [--core N]
      Runs the jobs of the seed from index --from on with the references of each, and appends to the file (JSON lines). A later call
      resumes. The report follows.
  report --rows FILE
      Prints the tables.
  job --seed S --index N
      Prints the job of a scene, for `raceway simulate -`.

Definitions:
  Stated error   `accuracy.level_errors_db` of each acceleration [dB]: an estimate of the error by the steps.
  References     The same job with `settle_s` of the run. "Fine" has an eighth of its step, "modes" the same step and modes up to 4 times the band,
                 "both" an eighth of the step and these modes, "check" a quarter of the step and these modes.
  Own error      Of "both": its difference from "check". In irregular motion both are samples, and the own error is large.
  Within         Off from "both" by at most the stated error (or three times it). The own error is added where it is smaller than the
                 stated error.
  Miss           Off by more than three times the stated error plus the own error, and by more than 0.002 dB.
  Unknown        The own error is larger than the stated one and could explain the distance.
  --limit        Largest processor time [s] of a run; the references may take 16 times as long. A scene beyond it is listed as too dear.

The shares of "fine" and of "modes" alone show whether steps or omitted modes make an error.
"""

import argparse
import hashlib
import json
import os
import statistics
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, os.pardir, "compare")]
import compare  # noqa: E402
import coverage  # noqa: E402
import scenes  # noqa: E402

PRESETS = ("608", "6203", "6204", "6205", "6206", "6208")
RANGE = 4.0
# Share of the run's step, and whether more modes are kept.
REFERENCES = {"fine": (0.125, False), "modes": (1.0, True), "both": (0.125, True), "check": (0.25, True)}
SHORTEST_US, REFERENCE_FACTOR = 0.1, 16.0


# ---- scenes --------------------------------------------------------------------------------------------------------


class Draw(compare.Draw):
    """Draws of one machine."""

    def __init__(self, seed, index):
        super().__init__(int.from_bytes(hashlib.sha256(f"machine {seed} {index}".encode()).digest()[:8], "big"))

    def job(self):
        preset = self.one_of(PRESETS)
        bore, width, balls, ball, pitch = scenes.PRESETS[preset]
        rating = 75.0 * balls ** (2 / 3) * ball**1.8
        length = round(bore * self.between(5.0, 20.0), 1)
        count = self.one_of((2, 2, 2, 2, 3, 4))
        places = self.places(count, length, width)
        shaft = {"sections": self.sections(length, bore)}
        discs = [{"at_mm": round(length * self.share(), 2), "mass_kg": self.between_decades(0.05, 3.0) * (bore / 25.0) ** 3}
                 for _ in range(self.one_of((0, 1, 1, 2)))]
        if discs:
            shaft["discs"] = [self.disc(disc, bore) for disc in discs]
        if self.chance(0.6):
            product = 0.01 * bore**3 * self.between_decades(1e-3, 0.3)
            shaft["unbalances"] = [{"at_mm": round(length * self.share(), 2), "unbalance_g_mm": float(f"{product:.3g}")}]
        if self.chance(0.4):
            shaft["damping_ratio"] = self.between_decades(0.002, 0.05)
        speed = float(f"{self.between_decades(2e4, 6e5) / pitch:.3g}")
        operation = {"speed_rpm": speed, "radial_load_y_n": float(f"{rating * self.between_decades(1e-3, 0.15):.3g}")}
        bearings = [{"name": "ABCD"[k], "bearing": preset, "at_mm": at, "faces": "+x" if k % 2 == 0 else "-x"}
                    for k, at in enumerate(places)]
        scene = {"shaft": shaft, "bearings": bearings, "operation": operation}
        if self.chance(0.5):
            force = float(f"{rating * self.between_decades(2e-3, 0.05):.3g}")
            scene["preloads"] = [{"between": ["A", "B"], "force_n": force}]
            shaft["axial"] = "free"
        if self.chance(0.5):
            scene["sensors"] = [{"name": "probe", "at_mm": round(length * self.share(), 2), "direction": self.one_of(("y", "z"))}]
        for bearing in bearings:
            if self.chance(0.3):
                bearing["lubricant"] = self.one_of(("grease", "oil"))
            if self.chance(0.15):
                bearing["surfaces"] = self.surfaces(ball)
        job = {"kind": "machine", "scene": scene, "duration_s": self.one_of((0.1, 0.1, 0.2, 0.3))}
        if self.chance(0.6):
            job["settle_s"] = self.between_decades(0.02, 0.3)
        self.loads(job, length, rating)
        return job

    def places(self, count, length, width):
        """Places of bearings that do not overlap, from one end to the other [mm]."""
        pitch = length / count
        free = max(0.0, pitch - 1.2 * width)
        return [round(k * pitch + 0.6 * width + free * self.share(), 2) for k in range(count)]

    def sections(self, length, bore):
        if self.chance(0.6):
            return [{"length_mm": length, "outer_diameter_mm": bore} | ({"inner_diameter_mm": round(0.5 * bore, 2)} if self.chance(0.2) else {})]
        share = self.between(0.2, 0.8)
        thick = round(bore * self.between(1.0, 2.0), 2)
        return [{"length_mm": round(share * length, 2), "outer_diameter_mm": bore},
                {"length_mm": round((1 - share) * length, 2), "outer_diameter_mm": thick}]

    def disc(self, disc, bore):
        mass = float(f"{disc['mass_kg']:.3g}")
        axial = 0.5 * mass * (2e-3 * bore * self.between(0.7, 2.0)) ** 2
        return {"at_mm": disc["at_mm"], "mass_kg": mass, "axial_inertia_kg_m2": float(f"{axial:.3g}"),
                "transverse_inertia_kg_m2": float(f"{axial * self.between(0.5, 0.9):.3g}")}

    def surfaces(self, ball):
        side = self.one_of(("inner", "outer"))
        if self.chance(0.5):
            return {side: {"random_waviness": {"amplitude_nm": self.between_decades(0.3, 30.0)}}}
        return {side: {"defects": [{"azimuth_deg": 0, "length_mm": float(f"{ball * self.between_decades(0.03, 0.3):.3g}"),
                                    "depth_um": self.between_decades(0.5, 30.0)}]}}

    def loads(self, job, length, rating):
        """Harmonic loads, a shock within the repeated time, or a run-up, in some jobs."""
        operation = job["scene"]["operation"]
        at = {"at_mm": round(length * self.share(), 2), "direction": self.one_of(("y", "z"))}
        size = float(f"{rating * self.between_decades(1e-3, 0.03):.3g}")
        kind = self.one_of(("none", "none", "none", "harmonic", "shock", "run-up"))
        if kind == "harmonic":
            harmonic = {"amplitude_n": size, "frequency_hz": self.between_decades(30.0, 5000.0), "phase_deg": 0}
            operation["loads"] = [at | {"harmonic": harmonic}]
        elif kind == "shock":
            job["settle_s"] = job.get("settle_s", 0.1)
            begin = float(f"{job['settle_s'] + 0.05 * self.share():.4g}")
            shock = {"peak_n": size, "at_s": begin, "duration_s": self.between_decades(2e-4, 5e-3)}
            operation["loads"] = [at | {"shock": shock}]
        elif kind == "run-up":
            job["settle_s"] = job.get("settle_s", 0.1)
            end = float(f"{job['settle_s'] + 0.1:.4g}")
            rpm = operation["speed_rpm"]
            operation["speed_rpm"] = [{"at_s": job["settle_s"], "rpm": rpm}, {"at_s": end, "rpm": float(f"{1.2 * rpm:.4g}")}]


def drawn(seed, index):
    return Draw(seed, index).job()


# ---- runs ----------------------------------------------------------------------------------------------------------


def simulate(runner, binary, job, limit):
    """Levels, stated errors, step and time; or the failure."""
    runner.cpu_limit = limit
    found = runner.run(binary, "simulate", job)
    if "failure" in found:
        status = "too dear" if found["failure"].startswith("not finished") else "failed"
        return {"status": status, "failure": found["failure"]}
    answer = json.loads(found["answer"])
    levels = {name: channel["level_db"] for name, channel in answer["channels"].items() if "level_db" in channel}
    return {"cpu_s": found["cpu_s"], "model": answer["model"], "levels": levels, "stated": answer["accuracy"]["level_errors_db"],
            "warnings": [one["code"] for one in answer.get("messages", []) if one["severity"] == "warning"]}


def row_of(seed, index, runner, binary, limit):
    job = drawn(seed, index)
    run = simulate(runner, binary, job, limit)
    row = {"seed": seed, "index": index, "binary": compare.label_of(binary), "date": compare.now(), **run}
    if "failure" in run:
        return row
    row["references"] = {}
    for name, (share, has_more) in REFERENCES.items():
        step = max(SHORTEST_US, float(f"{share * run['model']['step_us']:.4g}"))
        finer = job | {"settle_s": run["model"]["settle_s"], "step_us": step} | ({"mode_range": RANGE} if has_more else {})
        row["references"][name] = simulate(runner, binary, finer, REFERENCE_FACTOR * limit)
    return row


def run(options):
    runner = compare.Runner(3600.0, options.core)
    known = {(row["seed"], row["index"]) for row in compare.read_lines(options.rows)}
    for index in range(options.start, options.start + options.count):
        if (options.seed, index) not in known:
            row = row_of(options.seed, index, runner, options.binary, options.limit)
            compare.append(options.rows, row)
            given = [entry["verdict"] for entry in judged(row, "both")]
            compare.progress(f"{options.seed}/{index}: " + (row.get("failure") or ", ".join(sorted(given)))[:150])
    report(options)


# ---- report --------------------------------------------------------------------------------------------------------


def judged(row, by):
    """The verdict on each level with a stated error, by one of the references."""
    references = row.get("references", {})
    if "levels" not in references.get(by, {}):
        return []
    found = []
    for name, stated in row.get("stated", {}).items():
        reference = references[by]["levels"].get(name)
        if reference is None:
            continue
        off = abs(row["levels"][name] - reference)
        check = references["check"].get("levels", {}).get(name)
        both = references["both"].get("levels", {}).get(name)
        own = abs(both - check) if None not in (both, check) else 0.0
        verdict = coverage.verdict(off, stated, own, compare.INAUDIBLE_DB)
        found.append({"name": name, "row": row, "off": off, "stated": stated, "own": own, "verdict": verdict})
    return found


def report(options):
    rows = compare.read_lines(options.rows)
    answered = [row for row in rows if "levels" in row]
    print(f"{len(rows)} machines drawn: {len(answered)} answered, "
          + ", ".join(f"{sum(row.get('status') == status for row in rows)} {status}" for status in ("failed", "too dear")) + ".\n")
    coverage.heading("reference", "levels", "unknown", "judged", "within stated", "within 3 times", "minute", "misses", "sharpness")
    for by in ("fine", "modes", "both"):
        entries = [entry for row in answered for entry in judged(row, by)]
        given = [entry["verdict"] for entry in entries]
        count = {name: given.count(name) for name in ("unknown", *coverage.JUDGED)}
        total = sum(count[name] for name in coverage.JUDGED)
        within = (count["stated"], count["stated"] + count["thrice"])
        shares = [f"{100 * share / total:.1f} %" if total else "–" for share in within]
        ratios = [entry["stated"] / max(entry["off"], 1e-9) for entry in entries if entry["verdict"] in coverage.JUDGED]
        sharpness = f"{statistics.median(ratios):.2g}" if ratios else "–"
        coverage.line(by, len(entries), count["unknown"], total, *shares, count["minute"], count["miss"], sharpness)
    print()
    for verdict in ("miss", "minute", "unknown"):
        entries = [entry for row in answered for entry in judged(row, "both") if entry["verdict"] == verdict]
        if entries:
            coverage.heading("seed/index", verdict, "off [dB]", "stated", "own error", "step [µs]", "warnings")
        for entry in entries:
            row = entry["row"]
            coverage.line(coverage.name_of(row), entry["name"], f"{entry['off']:.3g}", f"{entry['stated']:.3g}", f"{entry['own']:.2g}",
                          f"{row['model']['step_us']:.3g}", ", ".join(sorted(set(row["warnings"]))))
        if entries:
            print()
    for row in rows:
        if "failure" in row:
            print(f"- {coverage.name_of(row)} {row['status']}: {' '.join(row['failure'].split())[:200]}")


# ---- command line --------------------------------------------------------------------------------------------------


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mode", choices=("run", "report", "job"))
    parser.add_argument("--binary", default="target/release/raceway")
    parser.add_argument("--rows", default="machines.jsonl")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--from", type=int, default=0, dest="start")
    parser.add_argument("--index", type=int, default=0)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--limit", type=float, default=60.0)
    parser.add_argument("--nice", type=int, default=0)
    parser.add_argument("--core", type=int)
    options = parser.parse_args()
    if options.nice:
        os.nice(options.nice)
    if options.mode == "job":
        print(json.dumps(drawn(options.seed, options.index), indent=2))
    else:
        (run if options.mode == "run" else report)(options)


if __name__ == "__main__":
    main()
