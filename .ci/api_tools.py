"""Tools for the API's description and its clients, installed once for each pinned set of versions (`.ci/checks/api`)."""

import os
import shutil
import subprocess
import sys

from service import ROOT, check, clean_environment

HERE = os.path.join(ROOT, ".ci", "checks", "api")
TOOLS = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "api-tools")
NODE, PYTHON = os.path.join(TOOLS, "node"), os.path.join(TOOLS, "python")


def run(*command, shown=True, environment=None, timeout=300, **options):
    """Both output streams of a command that must succeed."""
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=timeout, env=environment or clean_environment(), **options)
    if shown or done.returncode != 0:
        print(done.stdout, end="", flush=True)
    check(done.returncode == 0, f"{os.path.basename(command[0])} {' '.join(command[1:4])}… ends well")
    return done.stdout


def tool(name):
    return os.path.join(NODE, "node_modules", ".bin", name)


def python(name):
    return os.path.join(PYTHON, "bin", name)


def is_there(place, pins):
    """Whether the tools in a folder have the pinned versions. If not, the folder is emptied."""
    mark = os.path.join(place, "pinned")
    wanted = "".join(open(os.path.join(HERE, pin), encoding="utf-8").read() for pin in pins)
    if os.path.exists(mark) and open(mark, encoding="utf-8").read() == wanted:
        return True
    shutil.rmtree(place, ignore_errors=True)
    os.makedirs(place)
    for pin in pins:
        shutil.copy(os.path.join(HERE, pin), place)
    return False


def mark(place, pins):
    with open(os.path.join(place, "pinned"), "w", encoding="utf-8") as file:
        file.write("".join(open(os.path.join(HERE, pin), encoding="utf-8").read() for pin in pins))


def install_node():
    pins = ("package.json", "package-lock.json")
    if not is_there(NODE, pins):
        # Scripts of packages do not run, because none of these packages needs one.
        run("npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error", cwd=NODE, timeout=600)
        mark(NODE, pins)


def install_python():
    pins = ("requirements.txt",)
    if not is_there(PYTHON, pins):
        run(sys.executable, "-m", "venv", PYTHON)
        run(python("pip"), "install", "--quiet", "--disable-pip-version-check", "--no-deps", "-r",
            os.path.join(PYTHON, "requirements.txt"), timeout=600)
        mark(PYTHON, pins)
