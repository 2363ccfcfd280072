#!/usr/bin/env python3
"""Submits a job to a running service, follows it, prints levels and labelled lines, and saves spectrum.csv and spectrum.svg in the
current folder. Standard library only. A token, where the service wants one, is read from RACEWAY_TOKEN."""

import argparse
import json
import os
import sys
import time
import urllib.error
import urllib.parse
import urllib.request

TOKEN = os.environ.get("RACEWAY_TOKEN")
# Answers that say: later, after `Retry-After` seconds.
LATER = (429, 503)
TRIES = 10

JOB = {
    "kind": "simulation",
    "scene": {
        "bearing": "6205",
        "operation": {"speed_rpm": 6000, "radial_load_y_n": 500},
        "spindle": {"balance_grade": 6.3},
    },
}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url", nargs="?", default="http://127.0.0.1:8080", help="address of the service (default: %(default)s)")
    return parser.parse_args()


API = arguments().url.rstrip("/")


class Problem(Exception):
    """The service refused (RFC 9457); `fields` are the wrong ones of the body, each with its JSON pointer."""

    def __init__(self, status, problem):
        self.status, self.kind, self.fields = status, problem.get("type", ""), problem.get("errors", [])
        super().__init__(f"{status} {problem.get('title', '')}: {problem.get('detail', '')}")


def call(method, path, body=None, accept="application/json"):
    """The answer's body and headers; waits and tries again where the service asks for it."""
    headers = {"Accept": accept}
    if TOKEN:
        headers["Authorization"] = f"Bearer {TOKEN}"
    if body is not None:
        headers["Content-Type"] = "application/json"
        body = json.dumps(body).encode()
    # Links and `Location` are paths on this service.
    request = urllib.request.Request(urllib.parse.urljoin(f"{API}/", path), data=body, headers=headers, method=method)
    for tries_left in reversed(range(TRIES)):
        try:
            with urllib.request.urlopen(request, timeout=70) as answer:
                return answer.read(), answer.headers
        except urllib.error.HTTPError as error:
            if error.code in LATER and tries_left:
                time.sleep(float(error.headers.get("Retry-After", 1)))
                continue
            content = error.read()
            is_problem = error.headers.get_content_type() == "application/problem+json"
            raise Problem(error.code, json.loads(content) if is_problem else {"title": error.reason}) from None


def ask(method, path, body=None):
    """The answer as JSON, and its headers."""
    content, headers = call(method, path, body)
    return json.loads(content), headers


def run(job):
    """The job once it has ended."""
    state, headers = ask("POST", "/v1/jobs", job)
    while state["status"] in ("queued", "running"):
        print(f"{state['status']}, {state['progress']:.0%}", file=sys.stderr)
        time.sleep(float(headers.get("Retry-After", 1)))
        state, headers = ask("GET", state["links"]["self"])
    return state


def save(name, content):
    with open(name, "wb") as file:
        file.write(content)
    print(f"saved {name}")


def main():
    try:
        job = run(JOB)
        if job["status"] != "succeeded":
            sys.exit(f"the job is {job['status']}: {(job['error'] or {}).get('detail', '')}")
        links = job["links"]
        metrics, _ = ask("GET", links["metrics"])
        for name, channel in metrics["channels"].items():
            if "level_db" in channel:
                print(f"{name}: {channel['level_db']:.1f} dB re 9.81 mm/s², {channel['rms']:.3g} {channel['unit']} rms")
        print(f"the worst level is known within {metrics['accuracy'].get('level_error_db', float('nan')):.2g} dB")
        for line in metrics["lines"]:
            if line["label"]:
                print(f"{line['channel']}: {line['frequency_hz']:8.1f} Hz  {line['amplitude']:9.3g}  {line['label']}")
        # Of the first channel; `channel` names another one of links["channels"].
        save("spectrum.csv", call("GET", f"{links['spectrum']}?max_frequency_hz=5000", accept="text/csv")[0])
        save("spectrum.svg", call("GET", links["spectrum_svg"], accept="image/svg+xml")[0])
    except Problem as problem:
        for field in problem.fields:
            print(f"{field['pointer']}: {field['detail']}", file=sys.stderr)
        sys.exit(str(problem))
    except urllib.error.URLError as error:
        sys.exit(f"{API} does not answer: {error.reason}")


if __name__ == "__main__":
    main()
