"""Checks that consist of cases: functions `case_…(running)` that print verdicts. They run against a service of their own or, with a URL as
argument, against one that runs already, such as an older release."""

import sys

from service import Service, service

FAILED = []


class Running(Service):
    """A service that runs at a URL."""

    def __init__(self, url):
        self.url, self.token = url, None

    def stderr(self):
        return ""


def verdict(holds, what):
    """Prints one line; a failure does not stop the other cases."""
    print(f"{'ok' if holds else 'FAILED'}: {what}")
    if not holds:
        FAILED.append(what)


def result(running, job, view="metrics"):
    """A result of the finished job."""
    path, _ = running.submit(job)
    ended = running.ended(path)
    if ended["status"] != "succeeded":
        sys.exit(f"FAILED: {ended}")
    return running.request("GET", f"{path}/{view}")[2]


def finished(running, job):
    """The finished job; empty where the service refuses it."""
    status, _, answer = running.request("POST", "/v1/jobs", job)
    if status != 202:
        print(answer)
        return {}
    return running.ended(f"/v1/jobs/{answer['id']}", at_most=600)


def metrics(running, job):
    """Metrics of the finished job; empty where the service refuses it."""
    ended = finished(running, job)
    return running.request("GET", f"/v1/jobs/{ended['id']}/metrics")[2] if ended else {}


def run_cases(names):
    """Runs every case of a module; the exit status is 1 after a failed verdict."""
    def run(running):
        for name, case in list(names.items()):
            if name.startswith("case_"):
                case(running)

    if len(sys.argv) > 1:
        run(Running(sys.argv[1]))
    else:
        with service() as started:
            run(started)
    sys.exit(1 if FAILED else 0)
