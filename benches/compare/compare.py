#!/usr/bin/env python3
"""Comparison of two raceway binaries, old and new, on the same jobs: levels, stated errors, misses and wall times.

Usage (python3 benches/compare/compare.py MODE …):

  jobs [--write DIR]
      Lists the jobs. --write stores each as a file for `raceway simulate`.
  references --old BINARY --references FILE [--limit 60]
      Computes the reference levels with the old binary and appends them to FILE (JSON lines). A later call resumes.
  rows --binary BINARY --rows FILE [--label TEXT]
      Runs each job once and appends one row a job to FILE (JSON lines). A later call resumes.
  run --old BINARY --new BINARY [--references FILE] [--repeat N] [--csv FILE]
      Runs each job N times by both binaries, alternately, and prints the report.
      --old-rows FILE, --new-rows FILE: levels, errors and warnings of that side come from FILE (mode rows).
      The times always come from runs side by side. --repeat 0 runs nothing that has a row, and reports no times.
  speed --old BINARY --new BINARY [--repeat 3] [--csv FILE]
      Prints the verified speed (`solver.real_time_factor`) of default jobs, and the wall time of a map of 400 points.
      The goals were set on one machine. `goal new/old` is the goal over the factor of commit 96b61de on that machine.

Options of several modes:
  --group NAME    Only this group, repeatable: rungs, drawn-1, drawn-2, cases; in mode speed a part of the job's name.
  --first N       Only the first N scenes of each group.
  --core N        Runs the binaries on this core alone (Linux).
  --nice N        Lowers the priority of this program and of its runs (default 15 in mode references, else 0).
  --timeout S     Longest run in seconds (default 600).
  --old-label, --new-label   Names in the CSV and the report, for example commits; by default a digest of the binary.
  --note-codes A,B   Codes in `messages` that do not count as a warning although their severity is `warning`.

Jobs: 18 scenes of the rungs bench (0.02 s of settling, 0.1 s recorded), 100 drawn scenes of seed 1 and 60 of seed 2 as
`cargo bench --bench calibration -- drawn` draws them (0.03 s, 0.1 s), and the files in `cases` (their own times). Each runs
twice, with default settings: with all metrics, and with vibration only.

Definitions:
  Stated error   `channels.<spindle acceleration>.level_error_db`. A level without it is counted as `unstated`, never as a miss.
  Reference      Two runs on the rung `full` with `model_tolerance_db` 0: `gear` at 1e-8 and `dormand_prince` at 1e-7.
                 A reference is used only for runs by another method. Conventions of the model apply to all runs alike.
  Miss           A level that is off from every usable reference by more than 3 times its stated error, plus the error of the
                 reference, in a result without a warning. The report counts those above 0.002 dB separately.
                 The error of the reference is the stated one, or, in motion that does not diverge, the difference of the two
                 references where that is smaller.
                 Where the references contradict each other, the report lists the scene as `disputed`.
  Warning        `accuracy.warning`, or an entry of `messages` with the severity `warning` or `error`.
                 `accuracy.settling` is a remark and does not count.
  Other numbers  Largest loads, slips, pocket load, cage speed and cage orbit. The rule is that of `calibration -- drawn`: off by
                 more than 3 times both stated errors plus 1 %, in motion that does not diverge.

Files: a reference or a row belongs to a job by a digest of the job, so that files stay valid when jobs are added. Keep both
files outside the repository. Findings do not change the exit status, which is 0.
"""

import argparse
import csv
import datetime
import hashlib
import json
import math
import os
import platform
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
METRICS = {"all": ["vibration", "contacts", "cage"], "vibration": ["vibration"]}
AXES = ("x", "y", "z")
# A difference between two methods that is this small [dB] is of no consequence; as in benches/calibration/drawn.rs.
INAUDIBLE_DB = 2e-3
MISS_FACTOR = 3.0
# Relative difference of a single number that is of no consequence; as in benches/calibration/drawn.rs.
MINUTE = 1e-2
REFERENCES = (("gear", 1e-8), ("dormand_prince", 1e-7))
# Single numbers, and the field of `accuracy` that states the relative error of each.
NUMBERS = (
    ("/contacts/inner/max_load_n", "max_load_error"),
    ("/contacts/outer/max_load_n", "max_load_error"),
    ("/contacts/pocket/max_load_n", "max_pocket_load_error"),
    ("/contacts/inner/max_slip_m_s", "max_slip_error"),
    ("/contacts/outer/max_slip_m_s", "max_slip_error"),
    ("/kinematics/cage_speed_hz", "cage_speed_error"),
    ("/cage/orbit_radius_um", "orbit_radius_error"),
)


# ---- scenes --------------------------------------------------------------------------------------------------------

# r/min, N, diametral clearance [µm], balls, spindle [g], balance grade [mm/s]: as in benches/scenes/mod.rs.
RUNGS = (
    (50_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 7, 50.0, 6.3),
    (50_000.0, 200.0, 2.0, 7, 50.0, 0.0),
    (50_000.0, 200.0, 10.0, 7, 50.0, 0.0),
    (50_000.0, 50.0, 5.0, 7, 50.0, 0.0),
    (50_000.0, 400.0, 5.0, 7, 50.0, 0.0),
    (30_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (10_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (60_000.0, 200.0, 5.0, 7, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 6, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 8, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 9, 50.0, 0.0),
    (50_000.0, 200.0, 5.0, 7, 100.0, 0.0),
    (20_000.0, 100.0, 8.0, 8, 70.0, 2.5),
    (40_000.0, 300.0, 3.0, 9, 80.0, 6.3),
    (60_000.0, 100.0, 4.0, 6, 60.0, 1.0),
    (10_000.0, 50.0, 3.0, 9, 100.0, 0.0),
    (30_000.0, 400.0, 10.0, 8, 50.0, 6.3),
)


def rungs_scene(speed, load, clearance, balls, mass, grade):
    """One scene of the rungs bench."""
    # Nine balls of this size need a larger circle.
    pitch = 14.0 if balls > 8 else 13.0
    spindle = {"mass_kg": 1e-3 * mass}
    if grade > 0.0:
        spindle["balance_grade"] = grade
    return {
        "bearing": {
            "preset": "article-integrated", "ball_count": balls, "radial_clearance_um": clearance,
            "pitch_diameter_mm": pitch, "outer_diameter_mm": pitch + 5.0, "inner_diameter_mm": pitch - 4.5,
        },
        "spindle": spindle,
        "operation": {"speed_rpm": speed, "radial_load_y_n": load},
    }


class Draw:
    """The scenes of benches/calibration/drawn.rs: SplitMix64 and the same order of draws."""

    MASK = (1 << 64) - 1

    def __init__(self, seed):
        self.state = seed

    def next_u64(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) & self.MASK
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & self.MASK
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & self.MASK
        return z ^ (z >> 31)

    def share(self):
        return (self.next_u64() >> 11) / float(1 << 53)

    def chance(self, share):
        return self.share() < share

    def one_of(self, values):
        return values[int(self.share() * len(values))]

    def between(self, low, high):
        return float(f"{low + (high - low) * self.share():.2e}")

    def between_decades(self, low, high):
        return float(f"{low * math.pow(high / low, self.share()):.2e}")

    def scene(self):
        preset = self.one_of(("article-integrated", "article-integrated", "article-deep-groove", "608", "6205"))
        bearing = {"preset": preset}
        if self.chance(0.6):
            bearing["radial_clearance_um"] = self.between_decades(1.0, 40.0)
        if preset.startswith("article") and self.chance(0.5):
            bearing["ball_count"] = self.one_of((6, 7, 8, 9))
        if self.chance(0.3):
            bearing["inner_groove_curvature"] = self.between(0.51, 0.55)
        operation = {
            "speed_rpm": self.between_decades(3e3, 6e4),
            "radial_load_y_n": self.between_decades(20.0, 600.0),
        }
        if self.chance(0.3):
            operation["radial_load_z_n"] = self.between(-200.0, 200.0)
        spindle = {}
        if self.chance(0.5):
            spindle["mass_kg"] = self.between_decades(0.02, 2.0)
        if self.chance(0.4):
            spindle["balance_grade"] = self.one_of((0.4, 1.0, 2.5, 6.3, 16.0, 40.0))
        return {"bearing": bearing, "operation": operation, "spindle": spindle}


def bases(groups=None, first=None):
    """(group, name, job without solver and outputs) of each scene."""
    found = []
    for number, values in enumerate(RUNGS, 1):
        found.append(("rungs", f"rungs-{number:02}", {"scene": rungs_scene(*values), "settle_s": 0.02, "duration_s": 0.1}))
    for seed, count in ((1, 100), (2, 60)):
        draw = Draw(seed)
        for number in range(1, count + 1):
            base = {"scene": draw.scene(), "settle_s": 0.03, "duration_s": 0.1}
            found.append((f"drawn-{seed}", f"drawn-{seed}-{number:03}", base))
    folder = os.path.join(HERE, "cases")
    for name in sorted(os.listdir(folder)):
        if name.endswith(".json"):
            with open(os.path.join(folder, name), encoding="utf-8") as file:
                job = json.load(file)
            base = {key: job[key] for key in ("scene", "settle_s", "duration_s") if key in job}
            found.append(("cases", "case-" + name.removesuffix(".json"), base))
    chosen, counts = [], {}
    for item in found:
        counts[item[0]] = counts.get(item[0], 0) + 1
        if (not groups or item[0] in groups) and (first is None or counts[item[0]] <= first):
            chosen.append(item)
    return chosen


def digest(value):
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()[:16]


def jobs(groups=None, first=None):
    """Jobs as dicts: group, name, metrics (a key of METRICS), key, scene_key, job."""
    listed = []
    for group, name, base in bases(groups, first):
        for metrics, asked in METRICS.items():
            job = {"kind": "simulation", **base, "outputs": {"metrics": asked}}
            listed.append({"group": group, "name": name, "metrics": metrics, "key": digest(job),
                           "scene_key": digest(base), "job": job})
    return listed


# ---- runs ----------------------------------------------------------------------------------------------------------


class Runner:
    """Runs a binary on a job and measures wall time and processor time of the process."""

    def __init__(self, timeout, core=None):
        self.timeout = timeout
        # Largest processor time of a run [s]; `None`: no limit.
        self.cpu_limit = None
        self.environment = {key: value for key, value in os.environ.items() if not key.startswith("RACEWAY_")}
        if core is not None:
            os.sched_setaffinity(0, {core})

    def confine(self):
        limit = math.ceil(self.cpu_limit)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))

    def run(self, binary, command, job, *arguments):
        """{"wall_s", "cpu_s", "answer" (text of stdout) or "failure"}."""
        with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
            json.dump(job, file)
            file.flush()
            used = resource.getrusage(resource.RUSAGE_CHILDREN)
            begin = time.perf_counter()
            try:
                done = subprocess.run([binary, command, file.name, "--quiet", *arguments], capture_output=True, text=True,
                                      timeout=self.timeout, env=self.environment, check=False,
                                      preexec_fn=self.confine if self.cpu_limit else None)
            except subprocess.TimeoutExpired:
                return {"wall_s": self.timeout, "cpu_s": None, "failure": f"not finished after {self.timeout:g} s"}
            wall = time.perf_counter() - begin
        now = resource.getrusage(resource.RUSAGE_CHILDREN)
        found = {"wall_s": wall, "cpu_s": now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime}
        if done.returncode == -signal.SIGXCPU:
            return found | {"failure": f"not finished after {self.cpu_limit:g} s of processor time"}
        if done.returncode:
            return found | {"failure": f"exit status {done.returncode}: {done.stderr.strip()[:400]}"}
        return found | {"answer": done.stdout}

    def simulate(self, binary, job):
        """Wall time and what of the metrics is compared."""
        found = self.run(binary, "simulate", job)
        answer = found.pop("answer", None)
        return found if answer is None else found | extract(json.loads(answer))


def pointed(value, pointer):
    for key in pointer.strip("/").split("/"):
        if not isinstance(value, dict) or key not in value:
            return None
        value = value[key]
    return value


def extract(metrics):
    """The part of the metrics that is compared, stored and reported."""
    levels = {}
    for axis in AXES:
        channel = pointed(metrics, f"/channels/spindle.{axis}.acceleration")
        if channel and "level_db" in channel:
            levels[axis] = {key: channel.get(f"level_{key}") for key in ("db", "error_db", "scatter_db")}
    accuracy = metrics.get("accuracy", {})
    numbers = {}
    for pointer, error in NUMBERS:
        value = pointed(metrics, pointer)
        if value is not None:
            numbers[pointer] = [value, accuracy.get(error)]
    kept = ("rung", "method", "steps", "rhs_evaluations", "wall_time_s", "simulated_time_s", "real_time_factor")
    return {
        "levels": levels,
        "level_error_db": accuracy.get("level_error_db"),
        "motion": accuracy.get("motion"),
        "warning": accuracy.get("warning"),
        "settling": accuracy.get("settling"),
        "messages": [{key: message.get(key) for key in ("code", "severity", "text")} for message in metrics.get("messages", [])],
        "numbers": numbers,
        "omitted_by_judgement": {item["term"]: item.get("bound") for item in metrics.get("left_out", [])
                                 if item.get("by") == "judgement" and item.get("unit") == "dB"},
        **{key: metrics.get("solver", {}).get(key) for key in kept},
    }


def warnings(row, notes):
    """The warnings of a result, as texts."""
    found = [row["warning"]] if row.get("warning") else []
    for message in row.get("messages") or []:
        if message["severity"] in ("warning", "error") and message["code"] not in notes and message["text"] not in found:
            found.append(f"{message['code']}: {message['text']}")
    return found


def label_of(binary):
    with open(binary, "rb") as file:
        return "sha256:" + hashlib.sha256(file.read()).hexdigest()[:12]


def machine():
    model = platform.processor() or platform.machine()
    flags = ""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            for line in file:
                if line.startswith("model name"):
                    model = line.split(":", 1)[1].strip()
                if line.startswith("flags"):
                    flags = line
                    break
    except OSError:
        pass
    vector = next((name for name, flag in (("AVX-512", "avx512f"), ("AVX2", "avx2")) if flag in flags.split()), "")
    return f"{model}, {os.cpu_count()} cores{', ' + vector if vector else ''}"


def now():
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")


def read_lines(path):
    """Rows of a file of JSON lines; a last line that was cut off is ignored."""
    if not path or not os.path.exists(path):
        return []
    found = []
    with open(path, encoding="utf-8") as file:
        for line in file:
            try:
                found.append(json.loads(line))
            except json.JSONDecodeError:
                print(f"{path}: a line that is no JSON is ignored", file=sys.stderr)
    return found


def append(path, row):
    with open(path, "a", encoding="utf-8") as file:
        file.write(json.dumps(row) + "\n")


def progress(text):
    print(text, file=sys.stderr, flush=True)


# ---- references and rows -------------------------------------------------------------------------------------------


def compute_references(options):
    label = options.old_label or label_of(options.old)
    runner = Runner(options.limit, options.core)
    known = {(row["scene_key"], row["method"], row["relative_tolerance"]) for row in read_lines(options.references)}
    scenes = {job["scene_key"]: job for job in jobs(options.group, options.first)}
    # One method after the other: each scene has one reference early.
    for method, tolerance in REFERENCES:
        for number, (key, item) in enumerate(scenes.items(), 1):
            if (key, method, tolerance) in known:
                continue
            solver = {"rung": "full", "method": method, "relative_tolerance": tolerance, "model_tolerance_db": 0}
            job = item["job"] | {"solver": solver, "outputs": {"metrics": METRICS["all"]}}
            found = runner.simulate(options.old, job)
            append(options.references, {"scene_key": key, "name": item["name"], "relative_tolerance": tolerance,
                                        "binary": label, "date": now(), **found, "method": method})
            progress(f"{method} {number}/{len(scenes)} {item['name']}: {found['wall_s']:.1f} s {found.get('failure', '')}")


def own_errors(rows):
    """Sets `own_db` of each level of a scene's references: the numerical error of the reference [dB].

    The stated error contains the unevenness of the recorded time, which run and reference share. Where the motion does not
    diverge, two methods that agree bound the numerical error by their difference.
    """
    decaying = len(rows) > 1 and all(row["motion"] == "decaying" for row in rows)
    for row in rows:
        for axis, level in row["levels"].items():
            bounds = [level["error_db"]]
            if decaying:
                bounds += [abs(level["db"] - other["levels"][axis]["db"]) for other in rows
                           if other is not row and axis in other["levels"]]
            level["own_db"] = min((bound for bound in bounds if bound is not None), default=None)


def load_references(path):
    """Finished references by scene: {scene_key: [row, …]}, and notes on those that are missing."""
    found, notes = {}, []
    for row in read_lines(path):
        if "failure" in row:
            notes.append(f"{row['name']}, {row['method']} at {row['relative_tolerance']:g}: {row['failure']}")
        else:
            found.setdefault(row["scene_key"], []).append(row)
    for rows in found.values():
        own_errors(rows)
    return found, notes


def compute_rows(options):
    label = options.label or label_of(options.binary)
    runner = Runner(options.timeout, options.core)
    known = {row["key"] for row in read_lines(options.rows)}
    listed = jobs(options.group, options.first)
    for number, item in enumerate(listed, 1):
        if item["key"] in known:
            continue
        found = runner.simulate(options.binary, item["job"])
        header = {key: item[key] for key in ("key", "scene_key", "group", "name", "metrics")}
        append(options.rows, header | {"binary": label, "date": now(), "machine": machine()} | found)
        progress(f"{number}/{len(listed)} {item['name']} {item['metrics']}: {found['wall_s']:.2f} s {found.get('failure', '')}")


# ---- judgement -----------------------------------------------------------------------------------------------------


def usable(row, references):
    """References by another method than that of the run."""
    return [reference for reference in references if reference["method"] != row["method"]]


def off_from(row, axis, reference):
    """Distance of a level from a reference [dB] and what is allowed; `None` where one of them is missing."""
    own, other = row["levels"].get(axis), reference["levels"].get(axis)
    if not own or not other or own["error_db"] is None or other["own_db"] is None:
        return None
    return abs(own["db"] - other["db"]), MISS_FACTOR * own["error_db"] + other["own_db"]


def judge(row, references, notes):
    """{axis: {"off_db", "allowed_db", "reference", "verdict"}}; verdict: within, warned, miss, disputed, unstated or unknown."""
    judged = {}
    for axis in AXES:
        if axis not in row["levels"]:
            continue
        candidates = usable(row, references)
        pairs = [(off_from(row, axis, reference), reference) for reference in candidates]
        pairs = [(pair, reference) for pair, reference in pairs if pair]
        if row["levels"][axis]["error_db"] is None:
            judged[axis] = {"verdict": "unstated"}
        elif not pairs:
            judged[axis] = {"verdict": "unknown"}
        else:
            # The reference that speaks most for the level decides.
            (off, allowed), reference = min(pairs, key=lambda item: item[0][0] - item[0][1])
            beyond = [pair[0] > pair[1] for pair, _ in pairs]
            verdict = "within"
            if all(beyond):
                verdict = "warned" if warnings(row, notes) else "miss"
            elif any(beyond) and not warnings(row, notes):
                verdict = "disputed"
            judged[axis] = {"verdict": verdict, "off_db": off, "allowed_db": allowed,
                            "reference": f"{reference['method']} {reference['relative_tolerance']:g}"}
    return judged


def misjudged_numbers(row, references, notes):
    """Single numbers that are off from every usable reference by more than both state: [(pointer, value, reference, stated)]."""
    references = usable(row, references)
    if not references or warnings(row, notes) or "diverging" in [row["motion"], *(r["motion"] for r in references)]:
        return []
    found = []
    for pointer, (value, error) in row["numbers"].items():
        others = [r["numbers"][pointer] for r in references if pointer in r["numbers"]]
        if error is None or not others:
            continue
        excess = [abs(value - other) - (MISS_FACTOR * (error + (own or 0.0)) + MINUTE) * max(abs(value), abs(other))
                  for other, own in others]
        if min(excess) > 0.0:
            found.append((pointer, value, others[0][0], error))
    return found


def difference(old, new):
    """{axis: (difference [dB], sum of the stated errors or None)} of the levels that at least one side has."""
    found = {}
    for axis in AXES:
        a, b = old["levels"].get(axis), new["levels"].get(axis)
        if a and b:
            errors = [a["error_db"], b["error_db"]]
            found[axis] = (b["db"] - a["db"], None if None in errors else sum(errors))
        elif a or b:
            found[axis] = (None, None)
    return found


# ---- comparison ----------------------------------------------------------------------------------------------------


def median(values):
    values = [value for value in values if value is not None]
    return statistics.median(values) if values else None


def side_by_side(runner, binaries, job, repeat, first):
    """Rows of both sides; times are medians over the repetitions, the rest is that of the first one."""
    found = ([], [])
    for number in range(repeat):
        order = (0, 1) if (first + number) % 2 == 0 else (1, 0)
        for side in order:
            found[side].append(runner.simulate(binaries[side], job))
    return [rows[0] | {key: median([row.get(key) for row in rows]) for key in ("wall_s", "cpu_s", "wall_time_s")}
            for rows in found]


def compare(options):
    binaries = [options.old, options.new]
    stored = [{row["key"]: row for row in read_lines(path)} for path in (options.old_rows, options.new_rows)]
    given = (options.old_label, options.new_label)
    labels = [given[side] or next((row["binary"] for row in stored[side].values()), None)
              or (binaries[side] and label_of(binaries[side])) or ("old", "new")[side] for side in (0, 1)]
    runner = Runner(options.timeout, options.core)
    references, missing = load_references(options.references)
    notes = {code for code in (options.note_codes or "").split(",") if code}
    listed, compared = jobs(options.group, options.first), []
    for number, item in enumerate(listed):
        timed = side_by_side(runner, binaries, item["job"], options.repeat, number) if options.repeat else [None, None]
        rows = []
        for side in (0, 1):
            row = stored[side].get(item["key"]) or timed[side]
            if row is None:
                row = runner.simulate(binaries[side], item["job"]) if binaries[side] else {"failure": "no row and no binary"}
            times = ("wall_s", "cpu_s", "wall_time_s")
            rows.append(row | {key: timed[side].get(key) if timed[side] else None for key in times})
        compared.append({**item, "rows": rows, "is_timed": bool(options.repeat)})
        if (number + 1) % 20 == 0 or number + 1 == len(listed):
            progress(f"{number + 1}/{len(listed)}")
    for entry in compared:
        entry["references"] = references.get(entry["scene_key"], [])
        entry["judged"] = [judge(row, entry["references"], notes) if "levels" in row else {} for row in entry["rows"]]
        both = all("levels" in row for row in entry["rows"])
        entry["difference"] = difference(*entry["rows"]) if both else {}
    if options.csv:
        write_csv(options.csv, compared, labels, notes)
    report(compared, labels, missing, notes)


def write_csv(path, compared, labels, notes):
    """One line for each job and side."""
    per_axis = ("level_db", "error_db", "scatter_db", "off_from_reference_db", "allowed_db", "reference", "verdict")
    header = ["date", "machine", "group", "job", "metrics", "side", "binary", "rung", "method", "wall_s", "cpu_s",
              "solver_wall_time_s", "simulated_time_s", "motion", "warning", "settling", "failure", "other_numbers_off"]
    header += [f"{axis}_{name}" for axis in AXES for name in per_axis]
    date, where = now(), machine()
    with open(path, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        for entry in compared:
            for side, row in enumerate(entry["rows"]):
                line = [date, where, entry["group"], entry["name"], entry["metrics"], ("old", "new")[side], labels[side]]
                line += [row.get(key) for key in ("rung", "method", "wall_s", "cpu_s", "wall_time_s", "simulated_time_s", "motion")]
                off = [name for name, *_ in misjudged_numbers(row, entry["references"], notes)] if "levels" in row else []
                line += [" | ".join(warnings(row, notes)), row.get("settling"), row.get("failure"), " ".join(off)]
                for axis in AXES:
                    level, judged = row.get("levels", {}).get(axis) or {}, entry["judged"][side].get(axis, {})
                    line += [level.get(key) for key in ("db", "error_db", "scatter_db")]
                    line += [judged.get(key) for key in ("off_db", "allowed_db", "reference", "verdict")]
                writer.writerow(line)


def shown(value, digits=4):
    return "–" if value is None else f"{value:.{digits}f}"


def report(compared, labels, missing, notes):
    print(f"old: {labels[0]}, new: {labels[1]}; {machine()}; {now()}\n")
    summary(compared, notes)
    list_differences(compared, notes)
    for side, name in enumerate(("old", "new")):
        list_misses(compared, side, f"{name} ({labels[side]})")
    for side, name in enumerate(("old", "new")):
        list_numbers(compared, side, f"{name} ({labels[side]})", notes)
    list_remarks(compared, missing)


def summary(compared, notes):
    print("| group | metrics | jobs | levels within the sum of stated errors | unstated old, new | misses old, new (above "
          f"{INAUDIBLE_DB:g} dB) | disputed old, new | warned old, new | median wall time old, new [ms] | new/old | "
          "CPU time new/old | largest ratio |")
    print("|---|---|---|---|---|---|---|---|---|---|---|---|")
    groups = list(dict.fromkeys((entry["group"], entry["metrics"]) for entry in compared))
    for group in groups:
        print_summary(notes, " | ".join(group), [entry for entry in compared if (entry["group"], entry["metrics"]) == group])
    if len(groups) > 1:
        print_summary(notes, "all | both", compared)
    print()


def print_summary(notes, title, entries):
    pairs = [pair for entry in entries for pair in entry["difference"].values()]
    stated = [pair for pair in pairs if pair[1] is not None]
    within = sum(abs(apart) <= errors for apart, errors in stated)
    verdicts = [[judged for entry in entries for judged in entry["judged"][side].values()] for side in (0, 1)]

    def count(verdict):
        return ", ".join(str(sum(judged["verdict"] == verdict for judged in side)) for side in verdicts)

    misses = [[judged for judged in side if judged["verdict"] == "miss"] for side in verdicts]
    misses = ", ".join(f"{len(side)} ({sum(judged['off_db'] > INAUDIBLE_DB for judged in side)})" for side in misses)
    warned = ", ".join(str(sum(bool(entry["rows"][side].get("warning") or warnings(entry["rows"][side], notes)) for entry in entries))
                       for side in (0, 1))
    times = [(entry["rows"][0]["wall_s"], entry["rows"][1]["wall_s"], entry["name"]) for entry in entries
             if all(row.get("wall_s") is not None and "failure" not in row for row in entry["rows"])]
    cells = ["–"] * 4
    if times:
        old, new = (statistics.median(time[side] for time in times) for side in (0, 1))
        worst = max(times, key=lambda time: time[1] / time[0])
        cpu = [median([entry["rows"][side].get("cpu_s") for entry in entries]) for side in (0, 1)]
        cells = [f"{1e3 * old:.1f}, {1e3 * new:.1f}", f"{new / old:.2f}", f"{cpu[1] / cpu[0]:.2f}" if cpu[0] else "–",
                 f"{worst[1] / worst[0]:.2f} ({worst[2]}, {1e3 * worst[1]:.0f} ms)"]
    share = f"{within} of {len(stated)}" + (f" ({100 * within / len(stated):.1f} %)" if stated else "")
    row = [title, len(entries), share, count("unstated"), misses, count("disputed"), warned, *cells]
    print("| " + " | ".join(str(cell) for cell in row) + " |")


def by(row):
    return f"{row.get('rung')}/{row.get('method')}"


def list_differences(compared, notes):
    print("Level differences above the sum of the stated errors:\n")
    print("| job | metrics | axis | new − old [dB] | sum of stated errors [dB] | old by | new by | warning old, new |")
    print("|---|---|---|---|---|---|---|---|")
    for entry in compared:
        old, new = entry["rows"]
        for axis, (apart, errors) in entry["difference"].items():
            if apart is None or errors is not None and abs(apart) > errors:
                warned = ", ".join("yes" if warnings(row, notes) else "no" for row in (old, new))
                print(f"| {entry['name']} | {entry['metrics']} | {axis} | {shown(apart)} | {shown(errors)} | {by(old)} | "
                      f"{by(new)} | {warned} |")
    print()


def list_misses(compared, side, name):
    print(f"Misses and disputed levels of {name}:\n")
    print("| job | metrics | axis | verdict | off [dB] | stated [dB] | allowed [dB] | reference | by | motion |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for entry in compared:
        row = entry["rows"][side]
        for axis, judged in entry["judged"][side].items():
            if judged["verdict"] in ("miss", "disputed"):
                print(f"| {entry['name']} | {entry['metrics']} | {axis} | {judged['verdict']} | {judged['off_db']:.5f} | "
                      f"{row['levels'][axis]['error_db']:.5f} | {judged['allowed_db']:.5f} | {judged['reference']} | "
                      f"{by(row)} | {row['motion']} |")
    print()


def list_numbers(compared, side, name, notes):
    print(f"Other numbers off by more than stated, {name}:\n")
    print("| job | number | value | reference | stated error | by |")
    print("|---|---|---|---|---|---|")
    for entry in compared:
        row = entry["rows"][side]
        for pointer, value, reference, error in misjudged_numbers(row, entry["references"], notes) if "levels" in row else []:
            print(f"| {entry['name']} | {pointer} | {value:.5g} | {reference:.5g} | {100 * error:.2g} % | {by(row)} |")
    print()


def list_remarks(compared, missing):
    remarks = [f"reference missing: {note}" for note in missing]
    for entry in compared:
        for row, side in zip(entry["rows"], ("old", "new")):
            if "failure" in row:
                remarks.append(f"{entry['name']} {entry['metrics']}, {side}: {row['failure']}")
        times = {round(row["simulated_time_s"], 9) for row in [*entry["rows"], *entry["references"]] if row.get("simulated_time_s")}
        if len(times) > 1:
            remarks.append(f"{entry['name']} {entry['metrics']}: simulated times differ: {sorted(times)} s")
        if entry["metrics"] == "all":
            remarks.extend(contradictions(entry))
        if not entry["references"]:
            remarks.append(f"{entry['name']} {entry['metrics']}: no reference")
    if remarks:
        print("Remarks:\n")
        print("\n".join(f"- {remark}" for remark in remarks))


def contradictions(entry):
    """Pairs of references that differ by more than both state and by more than 0.002 dB."""
    found = []
    for axis in AXES:
        levels = [(row["method"], row["levels"][axis]) for row in entry["references"] if axis in row["levels"]]
        if len(levels) < 2 or any(level["error_db"] is None for _, level in levels):
            continue
        (one, a), (other, b) = levels[:2]
        if abs(a["db"] - b["db"]) > max(a["error_db"] + b["error_db"], INAUDIBLE_DB):
            found.append(f"{entry['name']} {axis}: references {one} {a['db']:.4f} ± {a['error_db']:.4f} dB and {other} "
                         f"{b['db']:.4f} ± {b['error_db']:.4f} dB contradict each other")
    return found


# ---- speed ---------------------------------------------------------------------------------------------------------

SPEED_SCENES = {
    "article": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200}},
    "article, G 6.3": {"bearing": "article-integrated", "operation": {"speed_rpm": 50000, "radial_load_y_n": 200},
                       "spindle": {"balance_grade": 6.3}},
    "6205": {"bearing": "6205", "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}, "spindle": {"balance_grade": 6.3}},
}
# A map of 20 × 20 points of the article's case, with default settings.
MAP = {
    "kind": "study", "scene": SPEED_SCENES["article"], "outputs": {"metrics": ["vibration"]},
    "axes": [{"path": "/operation/speed_rpm", "from": 30000, "to": 60000, "count": 20},
             {"path": "/bearing/radial_clearance_um", "from": 2, "to": 10, "count": 20}],
}


# (scene, recorded time [s], kind): goal of the real-time factor, and the factor of commit 96b61de where the goal was set,
# which is not known of every job.
GOALS = {
    ("article", 0.1, "all metrics"): (6, 4.0),
    ("article", 1, "all metrics"): (15, 6.1),
    ("article", 10, "all metrics"): (25, 4.3),
    ("6205", 0.1, "all metrics"): (5, 3.2),
    ("6205", 1, "all metrics"): (12, 3.3),
    ("6205", 10, "all metrics"): (18, 3.1),
    ("article", 0.1, "rung full"): (3, 2.3),
    ("article", 1, "rung full"): (5, 3.8),
    ("6205", 1, "rung full"): (2, 0.57),
    ("article", 10, "vibration alone"): (100, 42),
    ("article, G 6.3", 10, "vibration alone"): (100, 42),
    ("6205", 10, "vibration alone"): (100, None),
}


def speed_jobs():
    """(name, job, goal of the real-time factor or `None`, the goal as a ratio to the old binary or `None`)."""
    found = []
    for kind in ("all metrics", "rung full", "vibration alone"):
        alone = kind == "vibration alone"
        for name, scene in SPEED_SCENES.items():
            if name == "article, G 6.3" and not alone:
                continue
            for duration in (10,) if alone else (0.1, 1, 10):
                job = {"kind": "simulation", "scene": scene, "duration_s": duration}
                if kind == "rung full":
                    job["solver"] = {"rung": "full"}
                if alone:
                    job["outputs"] = {"metrics": ["vibration"]}
                goal, then = GOALS.get((name, duration, kind), (None, None))
                found.append((f"{name}, {duration:g} s, {kind}", job, goal, goal / then if then else None))
    return found


def speed(options):
    binaries = [options.old, options.new]
    labels = [options.old_label or label_of(options.old), options.new_label or label_of(options.new)]
    runner, lines = Runner(options.timeout, options.core), []
    print(f"old: {labels[0]}, new: {labels[1]}; {machine()}; {now()}; median of {options.repeat}, alternately\n")
    print("| job | real-time factor old | new | goal | new/old | goal new/old | run by old | run by new | wall time old, new [s] |")
    print("|---|---|---|---|---|---|---|---|---|")
    chosen = [item for item in speed_jobs() if not options.group or any(part in item[0] for part in options.group)]
    for number, (title, job, goal, goal_ratio) in enumerate(chosen):
        found = ([], [])
        for repetition in range(options.repeat):
            for side in (0, 1) if (number + repetition) % 2 == 0 else (1, 0):
                found[side].append(runner.simulate(binaries[side], job))
        factors = [median([row.get("real_time_factor") for row in rows]) for rows in found]
        walls = [median([row["wall_s"] for row in rows]) for rows in found]
        ratio = factors[1] / factors[0] if all(factors) else None
        failures = [row["failure"] for rows in found for row in rows if "failure" in row]
        print(f"| {title} | {shown(factors[0], 2)} | {shown(factors[1], 2)} | {goal or '–'} | {shown(ratio, 2)} | "
              f"{shown(goal_ratio, 1)} | {by(found[0][0])} | {by(found[1][0])} | {walls[0]:.3f}, {walls[1]:.3f} |{' ' + failures[0] if failures else ''}", flush=True)
        lines += [(title, ("old", "new")[side], factors[side], walls[side], goal, by(found[side][0])) for side in (0, 1)]
    if not options.group or any(part in "map" for part in options.group):
        lines += speed_of_map(options, runner, binaries)
    if options.csv:
        with open(options.csv, "w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["date", "machine", "job", "side", "binary", "real_time_factor", "wall_s", "goal", "run_by"])
            for title, side, *rest in lines:
                writer.writerow([now(), machine(), title, side, labels[side == "new"], *rest])


def speed_of_map(options, runner, binaries):
    found = ([], [])
    for repetition in range(options.repeat):
        for side in (0, 1) if repetition % 2 == 0 else (1, 0):
            with tempfile.TemporaryDirectory() as folder:
                run = runner.run(binaries[side], "study", MAP, "--workers", "1", "--output", folder)
                try:
                    with open(os.path.join(folder, "table.json"), encoding="utf-8") as file:
                        rows = json.load(file)["rows"]
                except (OSError, ValueError, KeyError):
                    rows = []
            run.pop("answer", None)
            run["points"] = sum(row.get("status") == "succeeded" for row in rows)
            run["simulated_s"] = sum(pointed(row, "/metrics/solver/simulated_time_s") or 0.0 for row in rows)
            found[side].append(run)
    walls = [median([run["wall_s"] for run in runs]) for runs in found]
    factors = [found[side][0]["simulated_s"] / walls[side] for side in (0, 1)]
    points = [f"{runs[0]['points']} points" + (f", {runs[0]['failure']}" if "failure" in runs[0] else "") for runs in found]
    title = "map of 400 points, vibration alone, one worker"
    print(f"| {title} | {factors[0]:.2f} | {factors[1]:.2f} | – | {walls[0] / walls[1]:.2f} | 2.0 | {points[0]} | {points[1]} | "
          f"{walls[0]:.3f}, {walls[1]:.3f} |")
    return [(title, ("old", "new")[side], factors[side], walls[side], "twice as fast", points[side]) for side in (0, 1)]


# ---- command line --------------------------------------------------------------------------------------------------


def list_jobs(options):
    for item in jobs(options.group, options.first):
        print(item["key"], item["group"], item["name"], item["metrics"], json.dumps(item["job"]["scene"]))
        if options.write:
            os.makedirs(options.write, exist_ok=True)
            with open(os.path.join(options.write, f"{item['name']}-{item['metrics']}.json"), "w", encoding="utf-8") as file:
                json.dump(item["job"], file, indent=2)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest="mode", required=True)

    def mode(name, function, priority=0):
        added = modes.add_parser(name)
        added.set_defaults(function=function)
        added.add_argument("--group", action="append")
        added.add_argument("--first", type=int)
        added.add_argument("--core", type=int)
        added.add_argument("--nice", type=int, default=priority)
        added.add_argument("--timeout", type=float, default=600.0)
        return added

    mode("jobs", list_jobs).add_argument("--write")
    added = mode("references", compute_references, 15)
    added.add_argument("--old", required=True)
    added.add_argument("--old-label")
    added.add_argument("--references", required=True)
    added.add_argument("--limit", type=float, default=60.0)
    added = mode("rows", compute_rows)
    added.add_argument("--binary", required=True)
    added.add_argument("--rows", required=True)
    added.add_argument("--label")
    for name, function, repeat in (("run", compare, 1), ("speed", speed, 3)):
        added = mode(name, function)
        added.add_argument("--old", required=name == "speed")
        added.add_argument("--new", required=name == "speed")
        added.add_argument("--old-label")
        added.add_argument("--new-label")
        added.add_argument("--repeat", type=int, default=repeat)
        added.add_argument("--csv")
    run = modes.choices["run"]
    for name in ("--references", "--old-rows", "--new-rows", "--note-codes"):
        run.add_argument(name)
    options = parser.parse_args()
    if options.mode == "run" and options.repeat and not (options.old and options.new):
        run.error("--old and --new are needed for times; --repeat 0 reports stored rows")
    if options.nice:
        os.nice(options.nice)
    options.function(options)


if __name__ == "__main__":
    main()
