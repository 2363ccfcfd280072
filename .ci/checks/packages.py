#!/usr/bin/env python3
"""The packages of a release, each installed from its file in a fresh environment: a labelled spectrum within a minute.

Without argument they are packed from the release build. The argument is a folder with the files of `.ci/release`; mypy then checks
the types, too."""

import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import time
import zipfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
import pack  # noqa: E402
from api_tools import tool  # noqa: E402
from service import ROOT, Service, binary, check, service  # noqa: E402

HOW_TO = pathlib.Path(ROOT, "docs", "how-to", "use-raceway-from-python.md")
TOKEN = "a-token-for-this-check"
# Longest way from the file to a labelled spectrum [s].
LIMIT_S = 60
# What a fresh user has: none of the variables of this one, but the settings by which the package clients find their registries.
CLIENTS = re.compile(r"(pip_.*|npm_config_.*|https?_proxy|no_proxy|ssl_cert_file|requests_ca_bundle|node_extra_ca_certs)", re.IGNORECASE)

SPECTRUM = """
import time
begin = time.monotonic()
import raceway
result = raceway.run({"bearing": "6205", "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}, "spindle": {"balance_grade": 6.3}})
print("labels:", [label for label in result.spectrum().labels() if label])
"""
MISSING = """
for method in (result.to_dataframe, result.plot_spectrum):
    try:
        method()
    except ImportError as error:
        print(error)
"""
REFUSED = """
import raceway
try:
    raceway.run({"bearing": "6205", "operation": {"speed_rpm": 1e9}, "spindle": {"mass_kg": -1}})
except raceway.Problem as problem:
    print(problem.status, problem.kind, sorted(error.pointer for error in problem.errors))
results = raceway.run_many([{"bearing": name, "operation": {"speed_rpm": 3000}} for name in ("6204", "nope")], duration_s=0.01, settle_s=0)
print([result.status for result in results], results[1].error.errors[0].pointer, list(results.rows()[0])[:3])
"""
# Runs for hours on a service, until it is interrupted. A program that a shell starts in the background ignores SIGINT.
ENDLESS = """
import signal, sys, raceway
signal.signal(signal.SIGINT, signal.default_int_handler)
print("running", flush=True)
raceway.Client(sys.argv[1], sys.argv[2]).run({"bearing": "6205", "operation": {"speed_rpm": 3000}}, duration_s=1000, progress=True)
"""
ABANDONED = """
import os, signal, raceway
print(raceway.local_client().transport.url, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
TYPES = """
import raceway
from raceway.schema import SceneInput

scene: SceneInput = {"bearing": "6205", "operation": {"speed_rpm": 3000, "radial_load_y_n": 500}}
result = raceway.run(scene, duration_s=0.1)
level: float = result.metrics["accuracy"]["level_error_db"]
labels: list[str] = result.spectrum().labels()
wrong: SceneInput = {"bearing": "6205", "operation": {"speed_rmp": 3000}}
"""
IN_NODE = """
import { Client, Refused } from "raceway";
const client = new Client(process.env.URL_OF_SERVICE, { token: process.env.TOKEN });
const scene = { bearing: "6205", operation: { speed_rpm: 3000, radial_load_y_n: 500 }, spindle: { balance_grade: 6.3 } };
const seen = [];
const job = await client.run({ kind: "simulation", scene }, { onProgress: (job) => seen.push(job.progress) });
const spectrum = await client.spectrum(job);
console.log("labels:", spectrum.lines.map((line) => line.label).join(" "), "of", spectrum.frequency_hz.length, "values;", seen.at(-1));
const refused = await client.submit({ kind: "simulation", scene: { ...scene, bearing: "nope" } }).catch((error) => error);
console.log(refused instanceof Refused, refused.at("/scene/bearing"));
const long = AbortSignal.timeout(500);
const stopped = await client.run({ kind: "simulation", scene, duration_s: 1000 }, { signal: long }).catch((error) => error.name);
const ended = await client.wait((await client.jobs({ limit: 1 }).next()).value);
console.log(stopped, ended.status);
"""
IN_TYPESCRIPT = """
import { Client, type JobRequest } from "raceway";
const good: JobRequest = { kind: "simulation", scene: { bearing: "6205", operation: { speed_rpm: 3000 } } };
const labels: Promise<string[]> = new Client().run(good).then((job) => new Client().spectrum(job)).then((all) => all.lines.map((one) => one.label));
// @ts-expect-error: the field has another name
const wrong: JobRequest = { kind: "simulation", scene: { bearing: "6205", operation: { speed_rmp: 3000 } } };
export { labels, wrong };
"""


def fresh(place):
    """The environment of a fresh user: standard programs, an empty home."""
    home = place / "home"
    home.mkdir(parents=True)
    kept = {name: value for name, value in os.environ.items() if CLIENTS.fullmatch(name)}
    # The settings of npm are a file of the home.
    npm = pathlib.Path.home() / ".npmrc"
    if npm.exists():
        shutil.copy(npm, home)
    cache = subprocess.run([sys.executable, "-m", "pip", "cache", "dir"], capture_output=True, text=True).stdout.strip()
    return kept | {"PATH": "/usr/local/bin:/usr/bin:/bin", "HOME": str(home), "LANG": "C.UTF-8", "PIP_CACHE_DIR": cache}


def run(*command, cwd, environment, timeout=300):
    """Standard output of a command that must succeed."""
    done = subprocess.run([str(word) for word in command], cwd=cwd, env=environment, stdin=subprocess.DEVNULL, capture_output=True,
                          text=True, timeout=timeout)
    name = pathlib.Path(command[0]).name
    check(done.returncode == 0, f"{name} {command[1]} ends well {done.stdout + done.stderr if done.returncode else ''}")
    return done.stdout


def in_time(begin, what):
    took = time.monotonic() - begin
    check(took < LIMIT_S, f"{what}: from the file to a labelled spectrum in {took:.1f} s")


def files(folder):
    """The wheel, the package for npm and the archive."""
    return [next(folder.glob(pattern)) for pattern in ("*_x86_64.whl", "*.tgz", "*-x86_64-linux.tar.gz")]


def packed(folder):
    """The files, packed from the release build."""
    folder.mkdir()
    notices = folder / "THIRD-PARTY-NOTICES"
    notices.write_text("", encoding="utf-8")
    made = pathlib.Path(binary())
    pack.npm(folder)
    # Little compression, because it takes most of the time.
    pack.archive(made, folder, {"THIRD-PARTY-NOTICES": notices}, level=1)
    wheel = pack.backend.wheel(made, folder, level=1)
    again = folder / "again"
    again.mkdir()
    check(pack.backend.wheel(made, again, level=1).read_bytes() == wheel.read_bytes(), "the same binary gives the same wheel")
    return files(folder)


def case_archive(archive, place):
    environment = fresh(place)
    begin = time.monotonic()
    run("tar", "xzf", archive, cwd=place, environment=environment)
    (unpacked,) = place.glob("raceway-*")
    run(unpacked / "raceway", "demo", "--once", cwd=place, environment=environment)
    check("BPFO" in (place / "spectrum.svg").read_text(encoding="utf-8"), "the archive's demo names BPFO in spectrum.svg")
    in_time(begin, archive.name)
    names = {path.name for path in unpacked.iterdir()}
    check({"LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY-NOTICES", "README.md", "docs"} <= names, "licences and documents are beside it")


def case_wheel(wheel, place, all_of_it):
    environment = fresh(place)
    python = place / "venv" / "bin" / "python"
    begin = time.monotonic()
    # The interpreter of the system: that of another environment could bring its packages.
    run(sys.executable, "-m", "venv", "venv", cwd=place, environment=environment)
    install = (python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
    run(*install, "--no-index", wheel, cwd=place, environment=environment)
    told = run(python, "-c", SPECTRUM, cwd=place, environment=environment)
    check("'BPFO'" in told, f"raceway.run gives a labelled spectrum: {told.strip()[:80]}…")
    in_time(begin, wheel.name)
    told = run(python, "-c", SPECTRUM + MISSING, cwd=place, environment=environment)
    check("needs pandas: pip install pandas" in told and "needs matplotlib: pip install matplotlib" in told, "a missing extra is named")
    told = run(place / "venv" / "bin" / "raceway", "--version", cwd=place, environment=environment)
    check(told == f"raceway {pack.backend.version()}\n", "the command raceway is the binary")
    told = run(python, "-c", REFUSED, cwd=place, environment=environment)
    check(told.splitlines()[0] == "422 invalid-request ['/scene/operation/speed_rpm', '/scene/spindle/mass_kg']", "a problem has all errors")
    check(told.splitlines()[1] == "['succeeded', 'refused'] /scene/bearing ['/bearing', 'status', 'error']", "of many jobs one is refused")
    case_ends(python, place, environment)
    # From here on with pandas and matplotlib.
    begin = time.monotonic()
    run(*install, "--no-compile", f"{wheel}[pandas,matplotlib]", cwd=place, environment=environment)
    print(f"pandas and matplotlib are installed in {time.monotonic() - begin:.1f} s")
    case_how_to(python, place, environment)
    if all_of_it:
        run(*install, "mypy==2.4.1", "pandas-stubs", cwd=place, environment=environment)
        case_types(python, place, environment)


def case_types(python, place, environment):
    def mypy(*arguments):
        return subprocess.run([python, "-m", "mypy", *arguments], cwd=place, env=environment, capture_output=True, text=True)

    typed = mypy("--strict", "--package", "raceway")
    check(typed.returncode == 0, f"mypy --strict accepts the module {typed.stdout if typed.returncode else ''}")
    (place / "typed.py").write_text(TYPES, encoding="utf-8")
    typed = mypy("typed.py")
    check('Extra key "speed_rmp"' in typed.stdout and "Found 2 errors" in typed.stdout, f"types know the fields of a scene {typed.stdout}")


def case_ends(python, place, environment):
    """The private service ends with its process, and an interruption cancels a job."""
    done = subprocess.run([python, "-c", ABANDONED], cwd=place, env=environment, capture_output=True, text=True, timeout=60)
    check(done.returncode == -signal.SIGKILL, "a program is killed")
    asked = [str(pathlib.Path(binary())), "health", "--listen", done.stdout.strip().removeprefix("http://")]
    deadline = time.monotonic() + 10
    while subprocess.run(asked, capture_output=True).returncode == 0 and time.monotonic() < deadline:
        time.sleep(0.1)
    check(time.monotonic() < deadline, "its private service ends with it")
    with served(place / "service") as running:
        program = subprocess.Popen([python, "-c", ENDLESS, running.url, TOKEN], cwd=place, env=environment, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        job = until_running(running)
        time.sleep(1)
        program.send_signal(signal.SIGINT)
        told = program.communicate(timeout=30)[1]
        check("KeyboardInterrupt" in told and "raceway [" in told, "a terminal shows the progress until Ctrl-C")
        check(running.ended(job)["status"] == "cancelled", "Ctrl-C cancels the job")


def until_running(running):
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        jobs = running.request("GET", "/v1/jobs?status=running")[2]["jobs"]
        if jobs:
            return jobs[0]["links"]["self"]
        time.sleep(0.05)
    sys.exit("FAILED: no job runs")


def case_how_to(python, place, environment):
    blocks = re.findall(r"```python\n(.*?)```", HOW_TO.read_text(encoding="utf-8"), re.DOTALL)
    check(len(blocks) >= 4, f"the how-to has {len(blocks)} blocks")
    with served(place / "service", token=None) as running:
        script = "\n".join(blocks).replace("http://127.0.0.1:8080", running.url)
        script += '\nprint(len(table), list(table.columns[:3]), set(table.status))\nax.figure.savefig("levels.png")\n'
        told = run(python, "-c", script, cwd=place, environment=environment | {"MPLBACKEND": "Agg"})
    print("\n".join(told.splitlines()[:8]))
    check("BPFO" in told and "['succeeded']" in told, "the how-to's blocks run as they stand")
    check("50 ['/operation/speed_rpm', 'status', 'error'] {'succeeded'}" in told, "fifty jobs are one table")
    check((place / "levels.png").stat().st_size > 1000, "and a plot")


def case_npm(package, archive, place):
    environment = fresh(place)
    begin = time.monotonic()
    run("tar", "xzf", archive, cwd=place, environment=environment)
    (unpacked,) = place.glob("raceway-*")
    project = place / "project"
    project.mkdir()
    (project / "package.json").write_text('{ "private": true, "type": "module" }', encoding="utf-8")
    run("npm", "install", "--offline", "--no-audit", "--no-fund", package, cwd=project, environment=environment)
    (project / "main.js").write_text(IN_NODE, encoding="utf-8")
    with served(place / "service", program=unpacked / "raceway") as running:
        told = run("node", "main.js", cwd=project, environment=environment | {"URL_OF_SERVICE": running.url, "TOKEN": TOKEN})
    print(told, end="")
    lines = told.splitlines()
    check("BPFO" in lines[0] and lines[0].endswith("; 1"), "the client gives a labelled spectrum and the progress")
    check(lines[1].startswith("true unknown bearing"), "a refusal has the text for its field")
    check(lines[2] == "TimeoutError cancelled", "an aborted run cancels its job")
    in_time(begin, package.name)
    installed = json.loads((project / "node_modules" / "raceway" / "package.json").read_text(encoding="utf-8"))
    check("dependencies" not in installed, "it has no dependencies")
    pinned = json.loads(pathlib.Path(ROOT, ".ci", "checks", "api", "package.json").read_text(encoding="utf-8"))["devDependencies"]
    check(installed["devDependencies"].items() <= pinned.items(), "it is compiled by the pinned tools")
    (project / "main.ts").write_text(IN_TYPESCRIPT, encoding="utf-8")
    options = {"strict": True, "noEmit": True, "exactOptionalPropertyTypes": True, "module": "nodenext", "lib": ["es2022", "dom"], "types": []}
    (project / "tsconfig.json").write_text(json.dumps({"compilerOptions": options, "files": ["main.ts"]}), encoding="utf-8")
    run(tool("tsc"), "--project", project, cwd=project, environment=os.environ)


def served(folder, program=None, token=TOKEN):
    """A service with a token, on an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    environment = {"PATH": "/usr/bin:/bin"} | ({"RACEWAY_API_TOKENS": token} if token else {})
    command = [str(program or binary()), "serve", "--listen", "127.0.0.1:0", "--database", f"sqlite://{folder / 'raceway.db'}"]
    return Running(Service(str(folder), command=command, environment=environment), token)


class Running:
    """A service that stops at the end of a block."""

    def __init__(self, running, token):
        self.running = running
        self.running.token = token

    def __enter__(self):
        return self.running

    def __exit__(self, *_):
        self.running.stop()


def main(folder):
    with tempfile.TemporaryDirectory(prefix="raceway-packages-") as directory:
        place = pathlib.Path(directory)
        begin = time.monotonic()
        if folder is None:
            wheel, package, archive = packed(place / "dist")
            print(f"packed in {time.monotonic() - begin:.1f} s: {wheel.name}")
        else:
            wheel, package, archive = files(folder.resolve())
            check(wheel.name.endswith("manylinux_2_28_x86_64.whl"), f"{wheel.name} is for glibc 2.28 or later")
        with zipfile.ZipFile(wheel) as content, tarfile.open(archive) as other:
            check(content.testzip() is None and len(other.getnames()) > 20, "the files are whole")
        for name, case in (
            ("archive", lambda: case_archive(archive, place / "a")),
            ("npm", lambda: case_npm(package, archive, place / "n")),
            ("wheel", lambda: case_wheel(wheel, place / "w", folder is not None)),
        ):
            begin = time.monotonic()
            print(f"--- {name}", flush=True)
            case()
            print(f"--- {name} took {time.monotonic() - begin:.1f} s", flush=True)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else None)
