#!/usr/bin/env python3
"""Owners of tokens do not harm each other: turns between them, their shares of the limits, and what headers tell about the rest. Counts
and ratios are checked; times are printed only. With RACEWAY the same cases run against another binary."""

import contextlib
import datetime
import http.client
import json
import os
import re
import secrets
import socket
import statistics
import sys
import tempfile
import threading
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, Service, clean_environment  # noqa: E402

WORKERS = 2
A, B = (secrets.token_hex(16) for _ in "ab")
SHORT = ARTICLE | {"reuse": False, "settle_s": 0.02, "duration_s": 0.05, "outputs": {"metrics": ["vibration"]},
                   "solver": {"model_tolerance_db": 0.2}}
failed = []


def check(holds, what):
    """Records whether the condition holds; the other cases still run."""
    print(f"{'ok' if holds else 'FAILED'}: {what}", flush=True)
    if not holds:
        failed.append(what)


def ask(service, token, method, path, body=None, **headers):
    return service.request(method, path, body, {"Authorization": f"Bearer {token}"} | headers)


def submit(service, token, job):
    status, fields, answer = ask(service, token, "POST", "/v1/jobs", job)
    return status, fields.get("Location"), answer


def submit_many(service, token, count, job):
    """Accepted jobs, by batches, with the waits that `Retry-After` asks for."""
    accepted = 0
    while accepted < count:
        batch = {"jobs": [job] * min(1000, count - accepted)}
        status, fields, answer = ask(service, token, "POST", "/v1/jobs/batch", batch)
        if status == 200:
            made = sum(item["status"] == 202 for item in answer["answers"])
            accepted += made
            if made == 0:
                break
        elif status == 429:
            time.sleep(int(fields["Retry-After"]))
        else:
            sys.exit(f"FAILED: a batch gives {status}: {answer}")
    return accepted


def when(job, field):
    return datetime.datetime.fromisoformat(job[field]).timestamp()


def listed(service, token, query):
    """Every job of a list."""
    jobs, path = [], f"/v1/jobs?limit=200&{query}"
    while path:
        page = ask(service, token, "GET", path)[2]
        jobs += page["jobs"]
        path = page.get("next")
    return jobs


def listed_first(service, token, query):
    """The first job of a list, in a list; an empty one without such jobs."""
    return ask(service, token, "GET", f"/v1/jobs?limit=1&{query}")[2]["jobs"]


def started(service, token, path, at_most):
    """The job once it has started; None after `at_most` seconds."""
    deadline = time.monotonic() + at_most
    while time.monotonic() < deadline:
        job = ask(service, token, "GET", path)[2]
        if job.get("started_at"):
            return job
        time.sleep(0.01)
    return None


def service_of(*options):
    """A service with the tokens of two owners, which is killed at the end: its queue may be long."""
    directory = tempfile.TemporaryDirectory(prefix="raceway-check-")
    environment = clean_environment(RACEWAY_API_TOKENS=f"{A},{B}")
    running = Service(directory.name, "--workers", str(WORKERS), *options, environment=environment)
    return directory, running


def with_service(*options):
    def of(case):
        def run():
            directory, running = service_of(*options)
            with directory:
                try:
                    case(running)
                finally:
                    running.kill()
        run.__name__ = case.__name__
        return run
    return of


def jobs_begin(service, what, submissions=9):
    """B's jobs of last priority begin within one running job per worker, though work of A waits."""
    waits, passed = [], []
    for _ in range(submissions):
        path = submit(service, B, SHORT | {"priority": 4})[1]
        job = started(service, B, path, at_most=4)
        if job is None:
            return check(False, f"B's job begins while {what} of A wait")
        begun, came = when(job, "started_at"), when(job, "created_at")
        waits.append(begun - came)
        if what == "5000 jobs":
            passed.append(sum(came < when(run, "started_at") < begun for run in
                              ask(service, A, "GET", "/v1/jobs?limit=200&status=running&status=succeeded")[2]["jobs"]
                              if run.get("started_at")))
        service.until_ended(B, path)
    waits.sort()
    print(f"    B waits {1e3 * statistics.median(waits):.1f} ms (median), {1e3 * waits[-1]:.1f} ms (99th percentile)")
    check(True, f"B's {submissions} jobs begin while {what} of A wait")
    return passed


def until_ended(self, token, path, at_most=30):
    deadline = time.monotonic() + at_most
    while time.monotonic() < deadline:
        job = ask(self, token, "GET", path)[2]
        if job["status"] not in ("queued", "running"):
            return job
        time.sleep(0.01)
    sys.exit(f"FAILED: a job has not ended after {at_most} s")


Service.until_ended = until_ended


@with_service("--queue-limit-per-owner", "6000", "--queue-limit", "12000", "--rate-limit", "0")
def case_queue_of_another_owner(service):
    check(submit_many(service, A, 5000, SHORT) == 5000, "5000 jobs of A are accepted")
    count = len(listed(service, A, "status=queued"))
    print(f"    {count} wait")
    passed = jobs_begin(service, "5000 jobs")
    if passed is not None:
        check(max(passed) <= WORKERS, f"at most {WORKERS} jobs of A begin before one of B: {passed}")


@with_service("--rate-limit", "0")
def case_studies_of_another_owner(service):
    study = SHORT | {"kind": "study", "axes": [{"path": "/operation/speed_rpm", "from": 30000, "to": 60000, "count": 1000}]}
    accepted = sum(submit(service, A, study)[0] == 202 for _ in range(40))
    check(accepted == 40, "40 studies of A are accepted")
    jobs_begin(service, "40 studies")


@with_service("--rate-limit", "0")
def case_accuracy_of_another_owner(service):
    accuracy = ARTICLE | {"kind": "accuracy", "repetitions": 9, "settle_s": 0.05, "duration_s": 0.4}
    paths = [submit(service, A, accuracy)[1]]
    started(service, A, paths[0], at_most=4)
    jobs_begin(service, "accuracy jobs", submissions=3)
    check(ask(service, A, "GET", paths[0])[2]["status"] == "running", "the accuracy job of A still runs")


@with_service("--queue-limit-per-owner", "2000", "--rate-limit", "0")
def case_shares_of_processor_time(service):
    """A sends short jobs, B jobs four times as long. While both wait, they get the same time."""
    submit_many(service, A, 1200, SHORT)
    submit_many(service, B, 300, SHORT | {"duration_s": 0.25})
    deadline = time.monotonic() + 60
    while all(listed_first(service, token, "status=queued") for token in (A, B)) and time.monotonic() < deadline:
        time.sleep(0.05)
    runs = {token: listed(service, token, "status=succeeded") for token in (A, B)}
    # Both wait from the first submission of B until the last start of the owner whose queue is empty first, whatever the
    # machine's speed.
    begin = min(when(run, "created_at") for run in runs[B])
    end = min(max(when(run, "started_at") for run in of_owner) for of_owner in runs.values())
    used = []
    for token in (A, B):
        spans = [(max(when(run, "started_at"), begin), min(when(run, "finished_at"), end)) for run in runs[token]]
        used.append(sum(to - since for since, to in spans if to > since))
    print(f"    both wait for {end - begin:.2f} s; processor time of A {used[0]:.2f} s, of B {used[1]:.2f} s")
    check(end - begin > 0.2, "both wait long enough for a comparison")
    check(0.6 < used[1] / max(used[0], 1e-9) < 1.7, f"time of B over time of A: {used[1] / max(used[0], 1e-9):.2f}")


@with_service("--queue-limit", "20", "--rate-limit", "0")
def case_half_of_the_queue(service):
    long = ARTICLE | {"reuse": False, "duration_s": 5}
    refused = [answer for status, _, answer in (submit(service, A, long) for _ in range(12)) if status == 429]
    check(len(refused) == 2, f"an owner holds half of a queue of 20: {12 - len(refused)} of 12 jobs accepted")
    check(submit(service, B, long)[0] == 202, "the other owner's job is accepted")


@with_service("--rate-limit", "0")
def case_half_of_the_points(service):
    study = SHORT | {"kind": "study", "axes": [{"path": "/operation/speed_rpm", "from": 30000, "to": 60000, "count": 10000}]}
    statuses = [submit(service, A, study)[0] for _ in range(6)]
    check(statuses[0] == 202, "a study of 10 000 points is accepted")
    check(statuses.count(429) == 1, f"an owner has at most 50 000 unfinished points: {statuses}")
    check(submit(service, B, study)[0] == 202, "the other owner's study is accepted")


@with_service("--rate-limit", "0", "--point-limit", "100")
def case_study_above_the_limit(service):
    study = SHORT | {"kind": "study", "axes": [{"path": "/operation/speed_rpm", "from": 30000, "to": 60000, "count": 51}]}
    status, _, answer = ask(service, A, "POST", "/v1/jobs", study)
    where = [error["pointer"] for error in answer.get("errors", [])] if isinstance(answer, dict) else []
    check(status == 422 and where == ["/axes"], f"a study above its owner's whole limit is refused for good: {status} {where}")


@with_service("--rate-limit", "0")
def case_half_of_the_waiting_requests(service):
    path = submit(service, A, ARTICLE | {"reuse": False, "duration_s": 10})[1]
    statuses, done = [], threading.Event()

    def follow():
        connection = http.client.HTTPConnection(service.url.removeprefix("http://"), timeout=30)
        connection.request("GET", f"{path}/events", headers={"Authorization": f"Bearer {A}"})
        answer = connection.getresponse()
        statuses.append(answer.status)
        done.wait(30)
        connection.close()

    threads = [threading.Thread(target=follow, daemon=True) for _ in range(140)]
    for thread in threads:
        thread.start()
    deadline = time.monotonic() + 20
    while len(statuses) < len(threads) and time.monotonic() < deadline:
        time.sleep(0.05)
    check(statuses.count(200) == 128, f"an owner has at most 128 event streams of 256: {statuses.count(200)}")
    status, fields, _ = ask(service, B, "POST", "/v1/jobs", SHORT, Prefer="wait=20")
    check(fields.get("Preference-Applied") == "wait=20", f"a request of the other owner waits: {status}")
    done.set()


@with_service("--rate-limit", "100")
def case_rate_by_cost(service):
    status, fields, answer = ask(service, A, "POST", "/v1/jobs/batch", {"jobs": [SHORT] * 300})
    check(status == 200 and all(item["status"] == 202 for item in answer["answers"]), "a batch larger than the bucket is accepted")
    policy, left = fields.get("RateLimit-Policy", ""), fields.get("RateLimit", "")
    check('"submissions";q=100;w=1' in policy and '"submissions";r=0' in left, f"its cost is a debt: {left!r} of {policy!r}")
    status, fields, _ = submit(service, A, SHORT)[0], None, None
    check(status == 429, "a submission in debt is refused")
    check(ask(service, A, "GET", "/v1/jobs?limit=1")[0] == 200, "reading is not charged")
    check(submit(service, B, SHORT)[0] == 202, "another owner has no debt")
    time.sleep(3)
    status, fields, _ = ask(service, A, "POST", "/v1/jobs", SHORT)
    check(status == 202, "the debt is paid after 2 s")
    check('"jobs";r=' in fields.get("RateLimit", ""), f"the answer tells the free places: {fields.get('RateLimit')!r}")


class Slider:
    """The slider of the page as it moves without end: a newer position cancels a preview that runs longer than the page waits, and the one
    after a cancelled preview ends."""

    HEAD_START = 0.25

    def __init__(self, service, token):
        self.host, self.headers = service.url.removeprefix("http://"), {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}
        self.statuses, self.cancelled, self.connection, self.leaving = [], 0, None, threading.Event()
        self.thread = threading.Thread(target=self.move, daemon=True)

    def __enter__(self):
        """Moves; the first preview has ended or gives way to a newer one."""
        self.thread.start()
        while not self.statuses and not self.cancelled:
            time.sleep(0.01)
        return self

    def __exit__(self, *_):
        """Leaves the page: the preview that runs is cancelled."""
        self.leaving.set()
        with contextlib.suppress(OSError, AttributeError):
            self.connection.sock.shutdown(socket.SHUT_RDWR)
        self.thread.join()

    def move(self):
        position, follows = 0, False
        while not self.leaving.is_set():
            position += 1
            job = {"kind": "simulation", "solver": {"model_tolerance_db": 1},
                   "scene": {"bearing": {"preset": "6205", "radial_clearance_um": 5 + position % 200 / 10},
                             "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}, "spindle": {"balance_grade": 6.3}},
                   "outputs": {"metrics": ["vibration"], "spectra": ["spindle.y.acceleration"]}}
            self.connection = http.client.HTTPConnection(self.host, timeout=30 if follows else self.HEAD_START)
            try:
                self.connection.request("POST", "/v1/preview", json.dumps(job), self.headers)
                answer = self.connection.getresponse()
                answer.read()
                self.statuses.append(answer.status)
                follows = False
            except (OSError, http.client.HTTPException) as error:
                if not isinstance(error, TimeoutError) and not self.leaving.is_set():
                    self.statuses.append(str(error))
                self.cancelled += 1
                follows = True
            finally:
                self.connection.close()


@with_service("--rate-limit", "0", "--queue-limit-per-owner", "1")
def case_slider_of_another_owner(service):
    """B's jobs, one after another, without and with a slider of A by turns. Owners have one place each."""
    times, counts, lists, sliders = {False: [], True: []}, [], [], []

    def jobs(slides):
        end, least = time.monotonic() + 0.7, len(times[slides]) + 3
        while time.monotonic() < end or len(times[slides]) < least:
            status, _, job = ask(service, B, "POST", "/v1/jobs", SHORT, Prefer="wait=60")
            if status != 200 or job["status"] != "succeeded":
                sys.exit(f"FAILED: a job of B gives {status}: {job}")
            times[slides].append(when(job, "finished_at") - when(job, "created_at"))
            figures = ask(service, B, "GET", "/metrics")[2].decode()
            counts.append(tuple(re.findall(r"^raceway_jobs_(?:waiting|running) (\d+)$", figures, re.MULTILINE)))
            lists.append(ask(service, A, "GET", "/v1/jobs?limit=1")[2]["jobs"])

    for _ in range(3):
        jobs(False)
        with Slider(service, A) as slider:
            sliders.append(slider)
            jobs(True)
    with Slider(service, A) as slider:
        sliders.append(slider)
        check(submit(service, A, SHORT)[0] == 202, "the only place of A is free while its slider moves")
    statuses = [status for slider in sliders for status in slider.statuses]
    cancelled = sum(slider.cancelled for slider in sliders)
    medians = [1e3 * statistics.median(times[slides]) for slides in (False, True)]
    print(f"    {len(statuses)} previews of A answered, {cancelled} cancelled by newer ones")
    print(f"    B's jobs take {medians[0]:.1f} ms without a slider of A, {medians[1]:.1f} ms with it (medians): ratio {medians[1] / medians[0]:.2f}")
    # 422: longer than previews may take, on a machine without time for them.
    check(set(statuses) <= {200, 422} and len(statuses) + cancelled > 0, f"previews are answered or cancelled: {set(statuses)}")
    count = sum(map(len, times.values()))
    check(True, f"all {count} jobs of B succeed")
    check(set(counts) == {("0", "0")}, f"between B's jobs none waits and none runs: {set(counts)}")
    check(not any(lists), "no preview is in A's list of jobs")
    check((len(listed(service, A, "")), len(listed(service, B, ""))) == (1, count), "the lists have the submitted jobs and no others")


CASES = [case for name, case in sorted(globals().items()) if name.startswith("case_")]
for case in CASES:
    if sys.argv[1:] and case.__name__ not in sys.argv[1:]:
        continue
    print(f"{case.__name__}:", flush=True)
    begin = time.monotonic()
    case()
    print(f"    {time.monotonic() - begin:.1f} s")
if failed:
    sys.exit(f"FAILED: {len(failed)} conditions do not hold")
