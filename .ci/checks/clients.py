#!/usr/bin/env python3
"""The API from the side of its clients. Linters and generators read the OpenAPI document, schemathesis compares the service with it,
and the examples run. Arguments select parts: description, types, client, examples, schemathesis."""

import contextlib
import os
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from api_tools import install_node, install_python, python, run, tool  # noqa: E402
from service import ROOT, Service, check, clean_environment, service  # noqa: E402

HERE = os.path.join(ROOT, ".ci", "checks", "api")
DOCUMENT = os.path.join(ROOT, "openapi", "openapi.json")
EXAMPLES = os.path.join(ROOT, "examples")
TOKEN = "a-token-for-this-check"


def description():
    """Linters have no findings."""
    run(tool("spectral"), "lint", DOCUMENT, "--ruleset", os.path.join(HERE, "spectral.yaml"), "--fail-severity", "hint",
        "--display-only-failures")
    told = run(tool("redocly"), "lint", DOCUMENT, "--config", os.path.join(HERE, "redocly.yaml"),
               environment=clean_environment(REDOCLY_TELEMETRY="off"))
    check("warning" not in told.lower(), "redocly has no warning")


def types(place):
    """Compiles the types for TypeScript and the example of a portal; returns the path of its program."""
    shutil.copytree(EXAMPLES, place)
    # Fields with a default are optional in requests.
    run(tool("openapi-typescript"), DOCUMENT, "--default-non-nullable=false", "--output", os.path.join(place, "raceway.d.ts"))
    run(tool("tsc"), "--strict", "--noEmit", os.path.join(place, "raceway.d.ts"))
    run(tool("tsc"), "--project", place)
    return os.path.join(place, "portal.js")


def generated_client(place, url):
    """A generated client for Python runs a job."""
    os.makedirs(place)
    run(python("openapi-python-client"), "generate", "--path", DOCUMENT, "--config", os.path.join(HERE, "python-client.yaml"),
        "--meta", "none", "--output-path", os.path.join(place, "raceway_client"), "--fail-on-warning")
    run(python("python"), os.path.join(HERE, "generated_client.py"), url, environment=clean_environment(PYTHONPATH=place))


def examples(portal, url, place):
    """Runs the examples on a service with tokens."""
    os.makedirs(place)
    environment = clean_environment(RACEWAY_TOKEN=TOKEN, RACEWAY_URL=url)
    told = run("node", portal, environment=environment)
    check("beside the field: 6000000 r/min" in told and "BPFO" in told and "501 points" in told, "portal.ts prints the expected lines")
    for command in ([sys.executable, os.path.join(EXAMPLES, "client.py"), url], [os.path.join(EXAMPLES, "curl.sh"), url]):
        for name in os.listdir(place):
            os.remove(os.path.join(place, name))
        told = run(*command, environment=environment, cwd=place, shown=False)
        print("\n".join(told.splitlines()[:8]))
        for name in ("spectrum.csv", "spectrum.svg"):
            check(os.path.getsize(os.path.join(place, name)) > 1000, f"{os.path.basename(command[-2])} saves {name}")
    check("5·BPFO" in run(*[sys.executable, os.path.join(EXAMPLES, "client.py"), url], environment=environment, cwd=place,
                          shown=False), "client.py names lines")
    told = run(sys.executable, os.path.join(EXAMPLES, "client.py"), "--help", environment=clean_environment(), shown=False)
    check("RACEWAY_TOKEN" in told and "http://127.0.0.1:8080" in told, "client.py --help describes purpose and options")
    refused = subprocess.run([sys.executable, os.path.join(EXAMPLES, "client.py"), url], capture_output=True, text=True,
                             timeout=60, env=clean_environment(RACEWAY_TOKEN="wrong"), cwd=place)
    check(refused.returncode == 1 and "401 A token is needed" in refused.stderr, "client.py reports a wrong token")


@contextlib.contextmanager
def served(folder, time_limit_s):
    """A service with a token. Generated scenes may be expensive: one at a time, with a short time limit."""
    os.makedirs(folder)
    running = Service(folder, "--workers", "1", "--time-limit-s", str(time_limit_s),
                      environment=clean_environment(RACEWAY_API_TOKENS=TOKEN))
    running.token = TOKEN
    try:
        yield running
    finally:
        running.stop()


def schemathesis(running, place):
    """Thousands of requests have responses that the OpenAPI document describes."""
    sys.path.insert(0, HERE)
    from examples import JOBS
    ids = {}
    for kind, job in JOBS.items():
        path = running.submit(job)[0]
        check(running.ended(path)["status"] == "succeeded", f"a job of kind {kind} has succeeded")
        ids[kind.upper()] = path.rsplit("/", 1)[1]
    with open(os.path.join(HERE, "schemathesis.toml"), encoding="utf-8") as given:
        rules = given.read()
    if os.environ.get("EVERY_OPERATION"):
        rules = rules.replace("phases.coverage.enabled = false", "phases.coverage.enabled = true")
    settings, without_ids = (os.path.join(place, name) for name in ("with-ids.toml", "without-ids.toml"))
    for path, text in ((settings, rules), (without_ids, rules.partition("# Jobs that have succeeded")[0])):
        with open(path, "w", encoding="utf-8") as kept:
            kept.write(text)

    def tried(url, phases, config):
        # A repeated key is answered with its job, which may be deleted by then: not every job in a response still
        # exists. This check is excluded here, because `--checks all` overrides the settings.
        run(python("schemathesis"), "--config-file", config, "run", f"{url}/openapi.json", "--checks", "all",
            "--exclude-checks", "ensure_resource_availability", "--phases", phases, "--no-color",
            environment=clean_environment(RACEWAY_TOKEN=TOKEN, **ids), timeout=1200, cwd=place)

    tried(running.url, "coverage,fuzzing", settings)
    # No test needs a succeeded job, and many jobs run until their time limit, one after the other.
    with served(os.path.join(place, "stateful"), 1) as brief:
        tried(brief.url, "examples,stateful", without_ids)


def install():
    install_node()
    install_python()


def main(parts):
    def timed(name, part, *arguments):
        begin = time.monotonic()
        print(f"--- {name}", flush=True)
        result = part(*arguments)
        print(f"--- {name} took {time.monotonic() - begin:.0f} s", flush=True)
        return result

    timed("install", install)
    with tempfile.TemporaryDirectory(prefix="raceway-clients-") as directory:
        place = lambda name: os.path.join(directory, name)  # noqa: E731
        if "description" in parts:
            timed("description", description)
        portal = timed("types", types, place("types")) if {"types", "examples"} & parts else None
        if "client" in parts:
            with service() as running:
                timed("client", generated_client, place("client"), running.url)
        if {"examples", "schemathesis"} & parts:
            with served(place("service"), 40) as running:
                if "examples" in parts:
                    timed("examples", examples, portal, running.url, place("saved"))
                if "schemathesis" in parts:
                    timed("schemathesis", schemathesis, running, directory)


if __name__ == "__main__":
    main(set(sys.argv[1:]) or {"description", "types", "client", "examples", "schemathesis"})
