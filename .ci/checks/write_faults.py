#!/usr/bin/env python3
"""A day of a service on SQLite, again and again, each time with one failing write, sync, open, truncation or removal of its files.

A day: start, single job, batch, study, a cancelled and an expiring job, results, SIGTERM; start, results, SIGTERM. The library
write_faults.c counts the calls on the folder of the database, by call and file. A fault begins with the n-th of them and lasts for
that call, half a second or five seconds: EIO, ENOSPC, or half of a write and then ENOSPC; or the process is killed at the call,
within a write. During it an answer is what it would be without fault, or a
problem that names the disk or the database. After it the service recovers by itself. After a restart without the library every
accepted job is there once, has the end that was seen, and can be read; its key gives its id; the file is intact.

    write_faults.py                      at most 60 days, spread over all calls and kinds of faults
    write_faults.py --every FILE         every call, with the faults in turn; FILE keeps the passed days, so that a run can be resumed
    write_faults.py --every FILE --all   every call with every fault
    write_faults.py --day CALL N FAULT   one day, with the log of the service if it fails: --day "write -wal" 17 torn
"""

import argparse
import collections
import concurrent.futures
import contextlib
import http.client
import json
import mmap
import os
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, binary, check, clean_environment  # noqa: E402

DAYS = 60
# Days at once. Most of a day is waiting, so that more of them than cores are useful.
TOGETHER = int(os.environ.get("TOGETHER", "4"))
# Longest time of a request, of recovery, of a start and of a stop [s].
LONGEST_S = 30
# Sweeps are as frequent as the limit of silence, so that recovery and expiry take a second.
OPTIONS = ["--listen", "127.0.0.1:0", "--workers", "1", "--lost-after-s", "1"]

IO_ERROR, NO_SPACE, TORN, KILL = range(4)
# Kind and duration [s] of a fault; 0: one call.
FAULTS = {
    "error": (IO_ERROR, 0), "full": (NO_SPACE, 0), "torn": (TORN, 0), "kill": (KILL, 0),
    "errors": (IO_ERROR, 0.5), "full-disk": (NO_SPACE, 0.5), "torn-full-disk": (TORN, 0.5), "long-errors": (IO_ERROR, 5),
}
CALLS = ["", "open", "write", "sync", "truncate", "unlink", "rename"]
FILES = ["database", "-wal", "-shm", "-journal", "folder"]
# Problems that a failing disk may cause, by status.
FULL = (507, "disk-full")
DOCUMENTED = {(503, "database-away"), (503, "not-ready"), FULL}


class Broken(Exception):
    """The service broke a promise."""


def hold(holds, what):
    if not holds:
        raise Broken(what)


def job(number, **more):
    operation = {"speed_rpm": 50000, "radial_load_y_n": 200 + number}
    return {"kind": "simulation", "scene": ARTICLE["scene"] | {"operation": operation}, "reuse": False, "settle_s": 0.01, "duration_s": 0.02,
            "solver": {"rung": "radially_condensed"}, "labels": [f"job-{number}"], **more}


# Long enough to be cancelled during its run.
LONG = job(1, settle_s=0, duration_s=60, solver={"rung": "full"})
SINGLE = job(2)
BRIEF = job(3, keep_for_s=1)
BATCH = {"jobs": [job(4), job(5), job(6)]}
STUDY = job(7) | {"kind": "study", "axes": [{"path": "/operation/radial_load_y_n", "from": 100, "to": 200, "count": 3}]}
LATER = job(8)
# Submitted only during a fault that lasts.
DURING = job(9)


class Control:
    """The control block of the library (`struct control`)."""

    HEAD = struct.Struct("=9Q")
    SIZE = HEAD.size + 65536

    def __init__(self, path):
        with open(path, "w+b") as file:
            file.truncate(self.SIZE)
            self.memory = mmap.mmap(file.fileno(), self.SIZE)

    def plan(self, name, number, fault):
        call, file = name.split()
        kind, span_s = FAULTS[fault]
        self.HEAD.pack_into(self.memory, 0, 0, CALLS.index(call) | FILES.index(file) << 4, 0, number, round(1e9 * span_s), kind, 0, 0, 0)

    @property
    def failed(self):
        """Number of calls that have failed."""
        return self.HEAD.unpack_from(self.memory)[6]

    def is_under_way(self):
        return self.failed > 0 and time.monotonic_ns() < self.HEAD.unpack_from(self.memory)[7]

    def names(self):
        """Call and file of each counted call."""
        calls = min(self.HEAD.unpack_from(self.memory)[0], 65536)
        return [f"{CALLS[byte & 15]} {FILES[byte >> 4]}" for byte in self.memory[self.HEAD.size:self.HEAD.size + calls]]


class Day:
    """One day of a service, what it answered, and what must therefore be true afterwards."""

    def __init__(self, library, directory, name=None, number=0, fault=None):
        self.directory = directory
        self.folder = os.path.join(directory, "data")
        os.mkdir(self.folder)
        control = os.path.join(directory, "control")
        self.control = Control(control)
        if name:
            self.control.plan(name, number, fault)
        self.environment = clean_environment(LD_PRELOAD=library, WRITE_FAULTS_FOLDER=self.folder, WRITE_FAULTS_CONTROL=control)
        self.service = None
        self.kills = fault == "kill"
        # An error of the disk is not reported as a full disk.
        self.documented = DOCUMENTED - ({FULL} if fault and FAULTS[fault][0] == IO_ERROR else set())
        # Answers by key: the paths of their jobs.
        self.paths = {}
        # Records of ended jobs as first seen, and the last status of the others.
        self.ends, self.status = {}, {}
        self.problems = collections.Counter()
        self.slowest_s = 0

    def command(self):
        return [binary(), "serve", *OPTIONS, "--database", f"sqlite://{self.folder}/raceway.db"]

    def start(self, environment):
        """Starts the service. A refused start names the database and is tried again, as a supervisor would."""
        deadline = time.monotonic() + LONGEST_S
        while True:
            try:
                self.service = Service(self.directory, command=self.command(), environment=environment)
                return
            except SystemExit as refused:
                told = str(refused)
            hold(environment is self.environment and self.control.failed, f"the start is refused without fault: {told}")
            if self.kills:
                continue
            hold("raceway.db" in told or "database" in told or "disk" in told, f"a refused start does not name the database: {told}")
            hold(time.monotonic() < deadline, f"the start is refused for {LONGEST_S} s: {told}")
            self.problems["start refused"] += 1
            time.sleep(0.1)

    def was_killed(self):
        """Whether the library has killed the process."""
        if not self.kills or not self.control.failed:
            return False
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self.service.process.wait(timeout=1) == -signal.SIGKILL
        return False

    def stop(self, may_fail=False):
        failed_before = self.control.failed
        process = self.service.process
        hold(process.poll() is None, f"the process has ended with {process.poll()} by itself")
        process.terminate()
        begin = time.monotonic()
        try:
            process.wait(timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            raise Broken(f"the service does not stop within {LONGEST_S} s of SIGTERM") from None
        self.slowest_s = max(self.slowest_s, time.monotonic() - begin)
        self.service.log.close()
        faulty = may_fail and (self.control.failed > failed_before or self.control.is_under_way())
        hold(process.returncode == 0 or (faulty and (process.returncode == 1 or self.was_killed())), f"the service stops with status {process.returncode}")

    def request(self, method, path, body=None, key=None, expected=(200, 202)):
        """Answer to a request, which is repeated while a problem of the disk is answered."""
        deadline = time.monotonic() + LONGEST_S
        while True:
            begin = time.monotonic()
            try:
                status, headers, answer = self.service.request(method, path, body, {"Idempotency-Key": key} if key else None, LONGEST_S)
            except (OSError, http.client.HTTPException) as error:
                if self.was_killed():
                    self.problems["killed"] += 1
                    self.start(self.environment)
                    continue
                raise Broken(f"{method} {path} is not answered: {error!r}") from None
            self.slowest_s = max(self.slowest_s, time.monotonic() - begin)
            if status in expected:
                refused = [item for item in answer.get("answers", []) if item["status"] != 202] if isinstance(answer, dict) else []
                for item in refused:
                    self.refusal(item["status"], item["problem"], f"a job of {method} {path}")
                if not refused:
                    return status, headers, answer
            else:
                self.refusal(status, answer, f"{method} {path}")
            hold(time.monotonic() < deadline, f"{method} {path} is still refused after {LONGEST_S} s: {answer}")
            time.sleep(0.05)

    def refusal(self, status, answer, what):
        kind = str(answer.get("type")).removeprefix("urn:raceway:problem:") if isinstance(answer, dict) else "no problem"
        hold((status, kind) in self.documented, f"{what} is answered with {status} {kind}: {answer}")
        hold(self.control.failed > 0, f"{what} is refused before the fault: {status} {kind}")
        self.problems[f"{status} {kind}"] += 1

    def submit(self, key, body):
        path = "/v1/jobs/batch" if "jobs" in body else "/v1/jobs"
        _, headers, answer = self.request("POST", path, body, key)
        made = [f"/v1/jobs/{item['job']['id']}" for item in answer["answers"]] if "jobs" in body else [headers["Location"]]
        hold(self.paths.setdefault(key, made) == made, f"the key {key} gives {made} after {self.paths[key]}")

    def look(self, path):
        """Record of a job. Its status never leaves an end. A fault that lasts meets a submission."""
        if self.control.is_under_way() and "during" not in self.paths:
            self.submit("during", DURING)
        record = self.request("GET", path)[2]
        if path in self.ends:
            for field in ("status", "finished_at", "error"):
                hold(record[field] == self.ends[path][field], f"the end of {path} has changed: {self.ends[path]}, then {record}")
        elif record["status"] in ("succeeded", "failed", "cancelled"):
            self.ends[path] = record
        self.status[path] = record["status"]
        return record

    def ended(self, path):
        deadline = time.monotonic() + LONGEST_S
        while (record := self.look(path))["status"] in ("queued", "running"):
            hold(time.monotonic() < deadline, f"{path} is {record['status']} {LONGEST_S} s later")
            time.sleep(0.02)
        return record

    def results(self):
        """Results of the jobs that do not expire, by key, without measured times."""
        read = {}
        for key in sorted(self.paths.keys() - {"brief", "long"}):
            for place, path in enumerate(self.paths[key]):
                record = self.ended(path)
                hold(record["status"] == "succeeded", f"{key} has {record['status']}: {record['error']}")
                found = self.request("GET", f"{path}/{'table' if key == 'study' else 'metrics'}")[2]
                if key == "study":
                    found = [[row["point"], row["metrics"]["channels"]] for row in found["rows"]]
                else:
                    found = found["channels"]
                    plot = self.request("GET", f"{path}/plots/spectrum.svg")[2]
                    hold(b"</svg>" in plot, f"the plot of {key} is not complete")
                read[key, place] = json.dumps(found, sort_keys=True)
        read.pop(("during", 0), None)
        return read

    def cancel(self):
        """Cancels the long job until it has been cancelled. A repetition meets a job that has ended meanwhile."""
        path, = self.paths["long"]
        self.request("POST", f"{path}/cancel")
        record = self.ended(path)
        hold(record["status"] == "cancelled", f"the cancelled job has {record['status']}: {record['error']}")

    def expire(self):
        """Waits until the brief job has expired."""
        path, = self.paths["brief"]
        deadline = time.monotonic() + LONGEST_S
        while self.request("GET", path, expected=(200, 404, 410))[0] == 200:
            hold(time.monotonic() < deadline, f"a job that is kept for 1 s is there {LONGEST_S} s later")
            time.sleep(0.1)

    def replay(self):
        for key, body in (("long", LONG), ("single", SINGLE), ("batch", BATCH), ("study", STUDY), ("later", LATER), ("during", DURING)):
            if key in self.paths:
                self.submit(key, body)

    def run(self):
        """The day. Returns the results."""
        self.start(self.environment)
        self.submit("long", LONG)
        self.submit("single", SINGLE)
        self.submit("brief", BRIEF)
        self.submit("batch", BATCH)
        self.submit("study", STUDY)
        self.cancel()
        hold(self.ended(self.paths["brief"][0])["status"] == "succeeded", "the brief job has not succeeded")
        self.results()
        self.replay()
        self.expire()
        self.stop(may_fail=True)
        self.start(self.environment)
        self.submit("later", LATER)
        self.results()
        self.stop(may_fail=True)

    def verify(self, expected):
        """Checks, without the library, what the day has left behind."""
        self.start(clean_environment())
        read = self.results()
        hold(expected is None or read == expected, "the results differ from those of the undisturbed day")
        hold(self.look(self.paths["long"][0])["status"] == "cancelled", "the cancellation is lost")
        self.replay()
        listed = self.request("GET", "/v1/jobs?limit=200")[2]["jobs"]
        paths = sorted(path for key, made in self.paths.items() if key != "brief" for path in made)
        hold(sorted(f"/v1/jobs/{record['id']}" for record in listed) == paths, f"there are {len(listed)} jobs for {len(paths)} answers")
        self.stop()
        with contextlib.closing(sqlite3.connect(f"{self.folder}/raceway.db")) as connection:
            told = connection.execute("PRAGMA integrity_check").fetchall()
            hold(told == [("ok",)], f"integrity_check: {told[:3]}")
            foreign = connection.execute("PRAGMA foreign_key_check").fetchall()
            hold(foreign == [], f"foreign_key_check: {foreign[:3]}")
        return read


def compiled(directory):
    library = os.path.join(directory, "write_faults.so")
    source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "write_faults.c")
    subprocess.run(["cc", "-O2", "-Wall", "-Wextra", "-Wshadow", "-Werror", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    return library


def undisturbed(library):
    """Number of each call of a day without fault, and the results."""
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        day = Day(library, directory)
        try:
            day.run()
            return collections.Counter(day.control.names()), day.verify(None)
        finally:
            if day.service:
                day.service.kill()


def disturbed(library, name, number, fault, expected):
    """A day with a fault. Returns a report: how many calls failed, which problems were answered, and what was broken."""
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        begin = time.monotonic()
        day, broken = Day(library, directory, name, number, fault), None
        try:
            day.run()
            day.verify(expected)
        except Broken as error:
            broken = str(error)
        finally:
            if day.service:
                day.service.kill()
        log = day.service.stderr()[-6000:] if broken and day.service else ""
        return {"call": name, "number": number, "fault": fault, "failed": day.control.failed, "problems": dict(day.problems),
                "slowest_s": round(day.slowest_s, 2), "took_s": round(time.monotonic() - begin, 2), "broken": broken, "log": log}


def every(counted):
    """Every call of a day."""
    return [(name, number) for name, count in sorted(counted.items()) for number in range(1, count + 1)]


def spread(counted, most):
    """Calls of a day: the first and the last of each kind, and others at equal distances."""
    ends = {end for name, count in counted.items() for end in ((name, 1), (name, count))}
    others = [call for call in every(counted) if call not in ends]
    places = max(0, min(most - len(ends), len(others)))
    return sorted(ends)[:most] + [others[(2 * k + 1) * len(others) // (2 * places)] for k in range(places)]


def in_turn(calls, faults):
    return [(*call, faults[k % len(faults)]) for k, call in enumerate(calls)]


def run_days(library, days, expected, passed=None):
    """Runs the days and prints their sum. Returns whether all held."""
    begin, reports = time.monotonic(), []
    with concurrent.futures.ThreadPoolExecutor(TOGETHER) as pool:
        futures = [pool.submit(disturbed, library, *day, expected) for day in days]
        for future in concurrent.futures.as_completed(futures):
            report = future.result()
            reports.append(report)
            if report["broken"]:
                print(f"FAILED: --day '{report['call']}' {report['number']} {report['fault']}: {report['broken']}", flush=True)
            elif passed:
                passed.write(json.dumps({name: report[name] for name in ("call", "number", "fault", "failed", "slowest_s", "took_s")}) + "\n")
                passed.flush()
    calls, problems = collections.Counter(), collections.Counter()
    for report in reports:
        calls[report["call"] if report["failed"] else "none (a shorter day)"] += 1
        problems.update(report["problems"])
    broken = [report for report in reports if report["broken"]]
    slowest = max((report["slowest_s"] for report in reports), default=0)
    print("first failing calls:", ", ".join(f"{count} × {name}" for name, count in calls.most_common()))
    print("answers to the faults:", ", ".join(f"{count} × {name}" for name, count in problems.most_common()) or "none")
    print(f"{len(reports)} days in {time.monotonic() - begin:.0f} s, {sum(report['failed'] for report in reports)} failed calls; the slowest answer "
          f"or stop took {slowest:.1f} s, the longest day {max((report['took_s'] for report in reports), default=0):.1f} s")
    if passed is None:
        refusals = sum(count for name, count in problems.items() if name.startswith("50"))
        check(refusals >= 10, f"the faults reach clients: {refusals} refusals")
    return not broken


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--every", metavar="FILE")
    arguments.add_argument("--all", action="store_true")
    arguments.add_argument("--day", nargs=3, metavar=("CALL", "N", "FAULT"))
    chosen = arguments.parse_args()
    with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
        library = compiled(directory)
        counted, expected = undisturbed(library)
        listed = ", ".join(f"{count} × {name}" for name, count in counted.most_common())
        check(counted["sync -wal"] > 10, f"an undisturbed day makes {counted.total()} calls: {listed}")
        if chosen.day:
            name, number, fault = chosen.day
            report = disturbed(library, name, int(number), fault, expected)
            print(report.pop("log"), json.dumps(report, indent=1), sep="\n")
            check(not report["broken"], "the day passes")
            return
        if chosen.every:
            days = [(*call, fault) for call in every(counted) for fault in FAULTS] if chosen.all else in_turn(every(counted), list(FAULTS))
            passed = set()
            if os.path.exists(chosen.every):
                with open(chosen.every, encoding="utf-8") as file:
                    passed = {(report["call"], report["number"], report["fault"]) for report in map(json.loads, file)}
            left = [day for day in days if day not in passed]
            print(f"{len(left)} of {len(days)} days are left", flush=True)
            with open(chosen.every, "a", encoding="utf-8") as file:
                holds = run_days(library, left, expected, file)
        else:
            # The long fault is for the long form.
            short = [fault for fault, (_, span_s) in FAULTS.items() if span_s < 1]
            holds = run_days(library, in_turn(spread(counted, DAYS), short), expected)
        check(holds, "every day keeps what was accepted, answers with documented problems and recovers by itself")


if __name__ == "__main__":
    main()
