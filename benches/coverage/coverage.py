#!/usr/bin/env python3
"""Do stated errors cover the true ones? Drawn jobs with default settings, each beside a reference by another method.

Usage (python3 benches/coverage/coverage.py MODE …):

  run --binary BINARY --rows FILE --references FILE [--seed 1] [--from 0] [--count 100] [--only 3,17] [--cheapest-first]
      Runs the jobs of the seed from index --from on, computes the references that are missing, and appends to both files
      (JSON lines). A later call resumes. For another binary only its rows are computed, and rarely a reference.
      --only takes these indices instead. --cheapest-first takes jobs in the order of their estimates, so that an early report
      judges cheap scenes more often, and those whose estimate is too low. --report prints the report at the end.
  report --rows FILE --references FILE [--label TEXT]
      Prints the tables of one binary, by default that of the last row.
  job --seed S --index N
      Prints the job of a scene, for `raceway simulate` or a service.
  keep --binary BINARY --rows FILE --references FILE --output FILE [--count 12] [--limit 60]
      Writes scenes with their references to a small file for the mode check: the first that are cheap,
      judged and without a warning, because those state the sharpest errors.
  check --binary BINARY [--first 12] [--kept FILE]
      Runs the kept scenes and judges them by their stored references. The exit status is 1 on a miss.

Options of several modes:
  --limit S       Largest processor time [s] of a run, and of all references of a scene together. A scene beyond it is listed
                  as too dear.
  --physics TEXT  Name of the equations that the references solve (default 1). A change of the equations, not of their
                  solution, needs another name; references of other names are not used.
  --core N, --nice N, --label TEXT   As in benches/compare/compare.py.

Definitions:
  Stated error   `channels.<acceleration>.level_error_db` of levels [dB]; of loads, slips, cage speed and cage orbit the
                 share in `accuracy`. A number without it counts as unstated.
  Reference      The model level `full` with `model_tolerance_db` 0, by the first of `gear` at 1e-8, `dormand_prince` at 1e-7
                 and `radau` at 1e-9 that is not the method of the run and that finishes within half of what is left of the
                 limit. Its tolerance is at most that of the run. A second one follows where the first one does not confirm
                 every number.
                 A long startup is simulated by fixed steps in every run on `full`; its errors are therefore not covered.
  Chaotic motion Where the reference diverges, no single trajectory is right. The reference is then the mean over four
                 windows: the same recorded time by the same method at four tolerances, whose rounding makes them independent
                 samples where the motion has diverged. Levels are averaged as powers. Its error is the standard deviation of
                 the four over two. Windows at the same time serve profiles of speed as well, which later windows would not.
  Own error      Error of a reference: what it states, or, of two references, their difference where that is smaller.
  Within         Off from the reference that speaks most for the number by at most the stated error (or three times it). The
                 own error is added where it is smaller than the stated error.
  Miss           Off by more than three times the stated error plus the own error. Numbers that are off by less than 0.002 dB or
                 1 % are listed as minute, not as misses; the shares count them as not within.
  No reference   No reference finished, or its own error is larger than the stated one and could explain the distance.
  Disputed       Two references that differ by more than both state, by more than three times the stated error of the number,
                 and by more than is minute. Listed apart.
  Sharpness      Median of the stated error over the distance from the reference.
  Warning        `accuracy.warning`, or a message with the severity `warning` or `error`. It exempts no number: a transient or a
                 large error does not excuse a wrong one. A second table holds the results without a warning.
  Estimate       `cost.estimated_wall_time_s` of `POST /v1/scenes/resolve` beside the processor time of the run.

Rows carry a digest of the result without its times. It shows which results of another binary have the same bits.
Keep rows and references outside the repository.
"""

import argparse
import contextlib
import hashlib
import json
import math
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import urllib.error
import urllib.request

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "compare")]
import compare  # noqa: E402
import scenes  # noqa: E402

# Methods of references and their tolerances; the first one is the reference, the others its further samples in chaos.
REFERENCES = {
    "gear": (1e-8, 7e-9, 5e-9, 3e-9),
    "dormand_prince": (1e-7, 7e-8, 5e-8, 3e-8),
    "radau": (1e-9, 7e-10, 5e-10, 3e-10),
}
KINDS = {
    "/contacts/inner/max_load_n": "contact load", "/contacts/outer/max_load_n": "contact load",
    "/contacts/pocket/max_load_n": "pocket load", "/contacts/inner/max_slip_m_s": "slip",
    "/contacts/outer/max_slip_m_s": "slip", "/kinematics/cage_speed_hz": "cage speed",
    "/cage/orbit_radius_um": "cage orbit", **{f"level {axis}": f"level {axis}" for axis in compare.AXES},
}
TIMES = ("wall_time_s", "real_time_factor")
ESTIMATE_FACTOR = 10.0
KEPT = os.path.join(HERE, "kept.jsonl")


def is_level(name):
    return name.startswith("level")


# ---- runs ----------------------------------------------------------------------------------------------------------


def numbers(metrics):
    """{name: [value, stated error or None]}: both in dB of levels, otherwise both in the unit of the number."""
    compared = compare.extract(metrics)
    found = {f"level {axis}": [level["db"], level["error_db"]] for axis, level in compared["levels"].items()}
    for pointer, (value, share) in compared["numbers"].items():
        found[pointer] = [value, None if share is None else share * abs(value)]
    return found


def result_digest(metrics):
    """Digest of a result without its times."""
    solver = {key: value for key, value in metrics.get("solver", {}).items() if key not in TIMES}
    return compare.digest(metrics | {"solver": solver})


def simulate(runner, binary, job, limit):
    """Times and what of the result is compared, or times, `status` and `failure`."""
    runner.cpu_limit = limit
    found = runner.run(binary, "simulate", job)
    times = {"cpu_s": found["cpu_s"] or limit}
    if "failure" in found:
        status = "too dear" if found["failure"].startswith("not finished") else "failed"
        return times | {"status": status, "limit_s": limit, "failure": found["failure"]}
    metrics = json.loads(found["answer"])
    solver, compared = metrics["solver"], compare.extract(metrics)
    return times | {
        "solve_s": solver["wall_time_s"], "simulated_s": solver["simulated_time_s"], "rung": solver["rung"],
        "method": solver["method"], "tolerance": solver.get("relative_tolerance"), "motion": compared["motion"],
        "digest": result_digest(metrics), "warnings": compare.warnings(compared, ()), "numbers": numbers(metrics),
    }


@contextlib.contextmanager
def service(binary):
    """URL of a service of the binary that resolves scenes."""
    with tempfile.TemporaryDirectory() as folder:
        command = [binary, "serve", "--listen", "127.0.0.1:0", "--database", f"sqlite://{folder}/jobs.db"]
        running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        try:
            line = running.stdout.readline()
            if not line.startswith("listening on "):
                raise RuntimeError(f"the service of {binary} does not start: {line}")
            yield line.removeprefix("listening on ").strip()
        finally:
            running.terminate()
            running.wait()


def resolve(url, job):
    """Estimated and largest time [s], or `status` and `failure` of a refused job."""
    head = {"Content-Type": "application/json"}
    request = urllib.request.Request(url + "/v1/scenes/resolve", json.dumps(job).encode(), head)
    try:
        with urllib.request.urlopen(request, timeout=120) as answer:
            cost = json.load(answer)["cost"]
    except urllib.error.HTTPError as refusal:
        return {"status": "refused", "failure": json.load(refusal).get("detail", f"status {refusal.code}")}
    return {"estimate_s": cost.get("estimated_wall_time_s"), "most_s": cost.get("most_wall_time_s")}


def identity(job):
    """Digests of the job, and of what its references depend on."""
    scene = {key: value for key, value in job.items() if key != "outputs"}
    return {"key": compare.digest(job), "scene": compare.digest(scene)}


# ---- references ----------------------------------------------------------------------------------------------------


class References:
    """The stored runs of references of one name of the equations, and those that are computed now."""

    def __init__(self, lines, physics, path=None):
        self.physics, self.path, self.found = physics, path, {}
        for line in lines:
            if line["physics"] == physics:
                self.found[line["scene"], line["method"], line["relative_tolerance"]] = line

    def obtain(self, job, scene, method, tolerance, runner, binary, limit):
        """One run of a reference; `None` without a binary and a stored run."""
        known = self.found.get((scene, method, tolerance))
        if known and not (binary and is_worth_more(known, limit)):
            return known
        if not binary or limit < 1.0:
            return None
        solver = {"rung": "full", "method": method, "relative_tolerance": tolerance, "model_tolerance_db": 0}
        found = simulate(runner, binary, job | {"solver": solver, "outputs": {"metrics": list(scenes.METRICS)}}, limit)
        line = {"scene": scene, "physics": self.physics, "binary": compare.label_of(binary),
                "date": compare.now(), **found, "method": method, "relative_tolerance": tolerance}
        self.found[scene, method, tolerance] = line
        if self.path:
            compare.append(self.path, line)
        return line

    def of_method(self, job, row, method, runner, binary, budget):
        """The reference by one method, at least as tight as the run, or `None`. Takes its time from the budget."""
        scene, runs = row["scene"], []
        tighter = min(1.0, (row["tolerance"] or 1.0) / REFERENCES[method][0])
        for tolerance in (float(f"{tighter * tolerance:.3g}") for tolerance in REFERENCES[method]):
            # A chaotic scene needs four such runs.
            share = budget[0] / 2 if not runs else budget[0]
            run = self.obtain(job, scene, method, tolerance, runner, binary, share)
            if run is None:
                return None
            budget[0] -= run.get("cpu_s", 0.0)
            if "failure" in run:
                return None
            runs.append(run)
            if run["motion"] != "diverging":
                break
        return merged(runs)

    def of(self, job, row, runner=None, binary=None, limit=0.0, both=False):
        """The references of a row; with a binary those that it needs are computed."""
        budget, found = [limit], []
        for method in REFERENCES:
            if method == row["method"] or len(found) == 2:
                continue
            if found and binary and not both and is_confirmed(row, found[0]):
                break
            reference = self.of_method(job, row, method, runner, binary, budget)
            if reference:
                found.append(reference)
        bound_by_difference(found)
        return found

    def failures(self, scene):
        return [line for (of, *_), line in self.found.items() if of == scene and "failure" in line]


def merged(runs):
    """One reference of one run, or of the runs of a chaotic scene; `numbers` holds [value, own error] by name."""
    first = runs[0]
    head = {"by": f"{first['method']} {first['relative_tolerance']:g}", "motion": first["motion"], "samples": len(runs),
            "simulated_s": first["simulated_s"]}
    if len(runs) == 1:
        return head | {"numbers": {name: list(pair) for name, pair in first["numbers"].items()}}
    found = {}
    for name in first["numbers"]:
        values = [run["numbers"][name][0] for run in runs if name in run["numbers"]]
        if len(values) < len(runs):
            continue
        if is_level(name):
            mean = 10.0 * math.log10(statistics.fmean(10 ** (0.1 * value) for value in values))
        else:
            mean = statistics.fmean(values)
        found[name] = [mean, statistics.stdev(values) / math.sqrt(len(values))]
    return head | {"numbers": found}


def bound_by_difference(references):
    """Lets the difference of two references of decaying motion bound their own errors; keeps what they stated as `stated`."""
    for reference in references:
        reference["stated"] = {name: own for name, (_, own) in reference["numbers"].items()}
    if len(references) < 2 or any(reference["samples"] > 1 for reference in references):
        return
    one, other = (reference["numbers"] for reference in references)
    for name in one.keys() & other.keys():
        apart = abs(one[name][0] - other[name][0])
        for pair in (one[name], other[name]):
            pair[1] = apart if pair[1] is None else min(apart, pair[1])


def is_confirmed(row, reference):
    """Whether another reference would not change how the numbers are judged: each is within its stated error, or within three
    times it, of a reference whose own error is small."""
    for name, (value, error) in row["numbers"].items():
        if error is None or name not in reference["numbers"]:
            continue
        other, own = reference["numbers"][name]
        off = abs(value - other)
        if off > error and (off > compare.MISS_FACTOR * error or own is None or own > 0.1 * error):
            return False
    return True


# ---- judgement -----------------------------------------------------------------------------------------------------


def minute(name, value):
    """Distance from the reference that is of no consequence."""
    return compare.INAUDIBLE_DB if is_level(name) else compare.MINUTE * abs(value)


def judge(row, references):
    """[{"name", "kind", "verdict", …}] of the numbers of a row.

    Verdict: unstated, unknown, disputed, stated (within the stated error), thrice, minute or miss.
    """
    judged = []
    for name, (value, error) in row["numbers"].items():
        entry = {"name": name, "kind": KINDS[name], "value": value, "stated": error, "is_warned": bool(row["warnings"])}
        judged.append(entry)
        candidates = [(*reference["numbers"].get(name, (None, None)), reference["by"]) for reference in references]
        candidates = [item for item in candidates if item[1] is not None]
        if error is None:
            entry["verdict"] = "unstated"
        elif not candidates:
            entry["verdict"] = "unknown"
        else:
            other, own, by = min(candidates, key=lambda item: abs(value - item[0]) - item[1])
            entry |= {"off": abs(value - other), "own": own, "reference": other, "by": by}
            is_apart = is_disputed(name, value, error, references)
            entry["verdict"] = "disputed" if is_apart else verdict(entry["off"], error, own, minute(name, other))
    return judged


def verdict(off, error, own, least):
    """Verdict on a number that is `off` from a reference with the error `own`."""
    limit = compare.MISS_FACTOR * error
    if off <= error + (own if own <= error else 0.0):
        return "stated"
    if off <= limit or (off <= limit + own and own <= error):
        return "thrice"
    if off <= limit + own:
        return "unknown"
    return "miss" if off > least else "minute"


def is_disputed(name, value, error, references):
    if len(references) < 2 or any(name not in reference["numbers"] for reference in references):
        return False
    apart = abs(references[0]["numbers"][name][0] - references[1]["numbers"][name][0])
    owns = [reference["stated"][name] or 0.0 for reference in references]
    return apart > max(sum(owns), compare.MISS_FACTOR * error, minute(name, value))


# ---- mode run ------------------------------------------------------------------------------------------------------


def run(options):
    label = options.label or compare.label_of(options.binary)
    runner = compare.Runner(60.0 * options.limit, options.core)
    references = References(compare.read_lines(options.references), options.physics, options.references)
    known = {row["key"]: row for row in compare.read_lines(options.rows) if row["binary"] == label}
    with service(options.binary) as url:
        waiting = []
        for index in options.only or range(options.start, options.start + options.count):
            job = scenes.job(options.seed, index)
            row = known.get(identity(job)["key"])
            if not row or is_worth_more(row, options.limit):
                row = {"seed": options.seed, "index": index, **identity(job), "binary": label, "date": compare.now()}
                row |= resolve(url, job)
            waiting.append((index, job, row))
        if options.cheapest_first:
            waiting.sort(key=lambda item: item[2].get("estimate_s") or 0.0)
        for index, job, row in waiting:
            if not {"numbers", "status"} & row.keys():
                row |= simulate(runner, options.binary, job, options.limit)
            if row is not known.get(row["key"]):
                compare.append(options.rows, row)
            note = row.get("failure", "")
            if "numbers" in row:
                found = references.of(job, row, runner, options.binary, options.limit)
                note = f"{row['rung']}/{row['method']} {row['cpu_s']:.2f} s; " + verdicts(judge(row, found))
            compare.progress(f"{options.seed}/{index}: {note[:150]}")
    if options.report:
        options.label = label
        report(options)


def is_worth_more(line, limit):
    """Whether a stored run ended at a lower limit of processor time."""
    return line.get("status") == "too dear" and line["limit_s"] < 0.9 * limit


def verdicts(judged):
    counts = {}
    for entry in judged:
        counts[entry["verdict"]] = counts.get(entry["verdict"], 0) + 1
    return ", ".join(f"{count} {verdict}" for verdict, count in counts.items())


# ---- mode report ---------------------------------------------------------------------------------------------------


def report(options):
    lines = compare.read_lines(options.rows)
    if not lines:
        sys.exit(f"{options.rows}: no rows")
    label = options.label or lines[-1]["binary"]
    rows = list({row["key"]: row for row in lines if row["binary"] == label}.values())
    references = References(compare.read_lines(options.references), options.physics)
    others = {}
    for row in lines:
        if row["binary"] != label and "digest" in row:
            others.setdefault(row["key"], set()).add(row["digest"])
    entries = []
    for row in rows:
        if "numbers" in row:
            found = references.of(scenes.job(row["seed"], row["index"]), row)
            entries.append({"row": row, "references": found, "judged": judge(row, found)})
    print(f"Binary {label}; {compare.machine()}; {compare.now()}\n")
    print(f"{len(rows)} jobs drawn: {len(entries)} answered, " + ", ".join(
        f"{sum(row.get('status') == status for row in rows)} {status}" for status in ("refused", "failed", "too dear")) + ".")
    without = [entry for entry in entries if not entry["references"]]
    dear = sum(any(line["status"] == "too dear" for line in references.failures(entry["row"]["scene"])) for entry in without)
    chaotic = sum(any(reference["samples"] > 1 for reference in entry["references"]) for entry in entries)
    print(f"{len(without)} answers without a reference, {dear} of them because it is too dear; "
          f"{chaotic} references of chaotic motion.")
    if others:
        same = sum(entry["row"]["digest"] in others.get(entry["row"]["key"], ()) for entry in entries)
        print(f"{same} results have the bits of another binary's.")
    print()
    tables([judged for entry in entries for judged in entry["judged"]])
    list_verdict(entries, "miss", "Misses")
    list_verdict(entries, "minute", "Beyond three times the stated error, but minute")
    list_verdict(entries, "disputed", "Disputed")
    list_jobs(rows, without, references)
    list_times(entries)
    estimates(rows)


JUDGED = ("stated", "thrice", "minute", "miss")


def line(*cells):
    print("| " + " | ".join(str(cell) for cell in cells) + " |")


def heading(*cells):
    line(*cells)
    print("|" + "---|" * len(cells))


def name_of(row):
    return f"{row['seed']}/{row['index']}"


def tables(judged):
    print("All results:\n")
    table(judged)
    print("Results without a warning:\n")
    table([entry for entry in judged if not entry["is_warned"]])


def table(judged):
    heading("kind", "numbers", "with a warning", "unstated", "no reference", "disputed", "judged", "within stated",
            "within 3 times", "minute", "misses", "sharpness")
    for kind in (*dict.fromkeys(KINDS.values()), "all"):
        chosen = [entry for entry in judged if kind in (entry["kind"], "all")]
        given = [entry["verdict"] for entry in chosen]
        count = {name: given.count(name) for name in ("unstated", "unknown", "disputed", *JUDGED)}
        total = sum(count[name] for name in JUDGED)
        within = (count["stated"], count["stated"] + count["thrice"])
        shares = [f"{100 * share / total:.1f} %" if total else "–" for share in within]
        line(kind, len(chosen), sum(entry["is_warned"] for entry in chosen), count["unstated"], count["unknown"],
             count["disputed"], total, *shares, count["minute"], count["miss"],
             "–" if kind == "all" else compare.shown(sharpness(chosen), 2))
    print()


def sharpness(judged):
    """Median of stated over true error of the numbers that are judged."""
    ratios = [entry["stated"] / entry["off"] if entry["off"] else math.inf for entry in judged
              if entry["verdict"] in JUDGED]
    return compare.median(ratios)


def list_verdict(entries, verdict, title):
    found = [(entry, judged) for entry in entries for judged in entry["judged"] if judged["verdict"] == verdict]
    if not found:
        return
    print(f"{title}:\n")
    heading("seed/index", "number", "value", "reference", "off", "stated", "off/stated", "own error", "reference by", "run by",
            "motion of run, reference", "warning")
    for entry, judged in found:
        row = entry["row"]
        ratio = judged["off"] / judged["stated"] if judged["stated"] else math.inf
        line(name_of(row), judged["name"], f"{judged['value']:.6g}", f"{judged['reference']:.6g}", f"{judged['off']:.3g}",
             f"{judged['stated']:.3g}", f"{ratio:.1f}", f"{judged['own']:.2g}", judged["by"], compare.by(row),
             f"{row['motion']}, {entry['references'][0]['motion']}", codes(row))
    print()


def codes(row):
    """Codes of the warnings of a row."""
    return ", ".join(sorted({text.split(":")[0] for text in row["warnings"]}))


def list_jobs(rows, without, references):
    listed = [f"{name_of(row)} {row['status']}: {' '.join(row['failure'].split())[:200]}" for row in rows if "status" in row]
    for entry in without:
        row = entry["row"]
        causes = [f"{run['method']}: {run['status']}, {run['failure'][:80]}" for run in references.failures(row["scene"])]
        listed.append(f"{name_of(row)} no reference: {'; '.join(causes) or 'not computed, or the limit is spent'}")
    if listed:
        print("Jobs without a judgement:\n")
        print("\n".join(f"- {text}" for text in listed) + "\n")


def list_times(entries):
    """Simulated times of run and reference that differ would compare different motions."""
    for entry in entries:
        times = {round(item["simulated_s"], 9) for item in (entry["row"], *entry["references"])}
        if len(times) > 1:
            print(f"- {name_of(entry['row'])}: simulated times differ: {sorted(times)} s")


def estimates(rows):
    """Estimated beside real processor time."""
    found = []
    for row in rows:
        if row.get("estimate_s") and "cpu_s" in row and row.get("status") != "failed":
            # The process also starts and prints, and the wall time also waits: the smaller one is nearer to the solution.
            found.append((min(row["cpu_s"], row.get("solve_s", math.inf)) / row["estimate_s"], row))
    if not found:
        return
    exceptions = [item for item in found if not 1 / ESTIMATE_FACTOR <= item[0] <= ESTIMATE_FACTOR]
    within, ratio = len(found) - len(exceptions), compare.median([item[0] for item in found])
    print(f"Estimated processor times: {within} of {len(found)} within a factor of {ESTIMATE_FACTOR:g} "
          f"({100 * within / len(found):.1f} %); median real over estimated {ratio:.2f}.\n")
    if exceptions:
        heading("seed/index", "estimated [s]", "real [s]", "real/estimated", "largest stated [s]", "run by")
        for ratio, row in sorted(exceptions, key=lambda item: item[0]):
            sign = "> " if row.get("status") == "too dear" else ""
            line(name_of(row), f"{row['estimate_s']:.3g}", f"{sign}{ratio * row['estimate_s']:.3g}", f"{sign}{ratio:.2g}",
                 f"{row['most_s']:.3g}", compare.by(row))


# ---- modes job, keep and check -------------------------------------------------------------------------------------


def print_job(options):
    print(json.dumps(scenes.job(options.seed, options.index), indent=2))


def keep(options):
    """The first cheap results without a warning, with at least three judged numbers and no miss, each with two references."""
    stored = References(compare.read_lines(options.references), options.physics, options.references)
    runner = compare.Runner(60.0 * options.limit, options.core)
    kept = []
    for row in compare.read_lines(options.rows):
        if len(kept) == options.count:
            break
        if "numbers" not in row or row["cpu_s"] > options.dearest or row["warnings"]:
            continue
        job = scenes.job(row["seed"], row["index"])
        if identity(job)["key"] != row["key"]:
            continue
        found = stored.of(job, row, runner, options.binary, options.limit, both=True)
        given = [entry["verdict"] for entry in judge(row, found)]
        if len(found) < 2 or sum(given.count(name) for name in JUDGED) < 3 or "miss" in given or "disputed" in given:
            continue
        fields = ("scene", "physics", "method", "relative_tolerance", "motion", "simulated_s", "numbers")
        runs = [{key: run[key] for key in fields} for (scene, *_), run in stored.found.items()
                if scene == row["scene"] and "failure" not in run]
        kept.append({"seed": row["seed"], "index": row["index"], "job": job, "references": runs})
    with open(options.output, "w", encoding="utf-8") as file:
        file.writelines(json.dumps(scene) + "\n" for scene in kept)
    print(f"{len(kept)} scenes")


def check(options):
    runner = compare.Runner(600.0, options.core)
    missed, judged = [], []
    for kept in compare.read_lines(options.kept)[:options.first]:
        row = identity(kept["job"]) | simulate(runner, options.binary, kept["job"], options.limit)
        name = name_of(kept)
        if "failure" in row:
            missed.append(f"{name}: {row['failure']}")
            continue
        references = References(kept["references"], kept["references"][0]["physics"])
        found = judge(row, references.of(kept["job"], row))
        judged += found
        if not any(entry["verdict"] in JUDGED for entry in found):
            missed.append(f"{name}: no number is judged")
        missed += [f"{name} {entry['name']}: {entry['value']:.6g}, reference {entry['reference']:.6g}, "
                   f"stated {entry['stated']:.2g}" for entry in found if entry["verdict"] == "miss"]
        print(f"{name}: {compare.by(row)}, {row['cpu_s']:.1f} s; {verdicts(found)}", flush=True)
    print()
    table(judged)
    print("\n".join(f"MISS {text}" for text in missed) or "no miss")
    sys.exit(1 if missed else 0)


# ---- command line --------------------------------------------------------------------------------------------------


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest="mode", required=True)

    def mode(name, function, *required):
        added = modes.add_parser(name)
        added.set_defaults(function=function)
        for option in required:
            added.add_argument(option, required=True)
        added.add_argument("--core", type=int)
        added.add_argument("--nice", type=int, default=0)
        added.add_argument("--limit", type=float, default=60.0)
        added.add_argument("--physics", default="1")
        added.add_argument("--label")
        return added

    added = mode("run", run, "--binary", "--rows", "--references")
    added.add_argument("--seed", type=int, default=1)
    added.add_argument("--from", type=int, default=0, dest="start")
    added.add_argument("--count", type=int, default=100)
    added.add_argument("--only", type=lambda text: [int(index) for index in text.split(",")])
    added.add_argument("--cheapest-first", action="store_true")
    added.add_argument("--report", action="store_true")
    mode("report", report, "--rows", "--references")
    added = mode("job", print_job)
    added.add_argument("--seed", type=int, default=1)
    added.add_argument("--index", type=int, required=True)
    added = mode("keep", keep, "--binary", "--rows", "--references", "--output")
    added.add_argument("--count", type=int, default=12)
    added.add_argument("--dearest", type=float, default=5.0)
    added = mode("check", check, "--binary")
    added.add_argument("--first", type=int, default=12)
    added.add_argument("--kept", default=KEPT)
    options = parser.parse_args()
    # A stop also stops the service that resolves scenes.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    if options.nice:
        os.nice(options.nice)
    options.function(options)


if __name__ == "__main__":
    main()
