#!/usr/bin/env python3
"""Rotor jobs beside ROSS: the exported script runs with ross-rotordynamics from PyPI, and natural frequencies, critical speeds and unbalance
response agree to the printed digits. The form for ROSS 3, which needs a newer Python, calls ROSS only by the recorded names of arguments.
With a URL as argument the rotors run there.

ROSS is installed once in a virtual environment under CI_TOOLS, else under the directory of temporary files."""

import ast
import builtins
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
from cases import result, run_cases, verdict  # noqa: E402

# ROSS 2.3.0 uses a plot type that plotly 6 removed.
PACKAGES = ("ross-rotordynamics==2.3.0", "plotly==5.24.1")
TOOLS = os.path.join(os.environ.get("CI_TOOLS", tempfile.gettempdir()), "raceway-ross")

# Names of the arguments of each call, in their order, without `self`. Names only: a class with `**kwargs` ignores others without a word.
SIGNATURES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "ross-3-signatures.json")

STEEL = {"elastic_modulus_gpa": 211, "poisson_ratio": 211 / (2 * 81.2) - 1, "density_kg_m3": 7810}


def support(at, stiffness, damping):
    return {"at_mm": at, "stiffness_n_per_um": [0, *stiffness], "damping_n_s_per_m": [0, damping, damping]}


def shaft(sections, disc, unbalance):
    listed = [{"length_mm": length, "outer_diameter_mm": outer, "inner_diameter_mm": inner}
              for count, length, outer, inner in sections for _ in range(count)]
    keys = ("at_mm", "mass_kg", "transverse_inertia_kg_m2", "axial_inertia_kg_m2")
    return {"material": STEEL, "sections": listed, "discs": [dict(zip(keys, disc))], "elements": "sections",
            "unbalances": [{"at_mm": disc[0], "unbalance_g_mm": unbalance, "phase_deg": 30}], "damping_ratio": 0}


MIDDLE = {
    "kind": "rotor", "speeds_rpm": [0, 6000, 12000, 18000, 24000, 30000],
    "scene": {"shaft": shaft([(30, 10, 25, 0)], (150, 1.2, 8e-4, 1.5e-3), 20), "operation": {"speed_rpm": 12000},
              "supports": [support(40, (50, 50), 200), support(260, (50, 50), 200)]}}
OVERHUNG = {
    "kind": "rotor", "speeds_rpm": [0, 10000, 20000, 30000, 40000],
    "scene": {"shaft": shaft([(2, 20, 30, 0), (8, 20, 40, 12), (3, 20, 35, 12)], (260, 2.5, 4e-3, 7e-3), 50),
              "operation": {"speed_rpm": 10000},
              "supports": [support(60, (100, 150), 500), support(180, (200, 260), 800)]}}

# Runs in the environment of ROSS: natural frequencies at each speed and at the critical speeds, and the unbalance response.
DRIVER = """
import json, runpy, sys
import numpy as np
made = runpy.run_path(sys.argv[1])
rotor, asked = made["rotor"], json.loads(sys.argv[2])
frequencies = lambda speed: rotor.run_modal(speed=speed, num_modes=28).wd.tolist()
response = made["unbalance_response"]()
forced = np.abs(response.forced_resp)
per_node = forced.shape[0] // len(rotor.nodes)
print(json.dumps({"speeds": [frequencies(speed) for speed in asked["speeds"]],
                  "criticals": [frequencies(speed) for speed in asked["criticals"]],
                  "response": [forced[per_node * node:per_node * node + 2].tolist() for node in asked["nodes"]]}))
"""


def python():
    """The interpreter of an environment with ROSS."""
    path = os.path.join(TOOLS, "bin", "python")
    mark = os.path.join(TOOLS, "pinned")
    wanted = "\n".join(PACKAGES)
    if not (os.path.exists(mark) and open(mark, encoding="utf-8").read() == wanted):
        shutil.rmtree(TOOLS, ignore_errors=True)
        subprocess.run([sys.executable, "-m", "venv", TOOLS], check=True)
        subprocess.run([path, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES],
                       check=True, timeout=900)
        with open(mark, "w", encoding="utf-8") as file:
            file.write(wanted)
    return path


def script_of(running, job, version):
    path, _ = running.submit(job)
    ended = running.ended(path)
    if ended["status"] != "succeeded":
        sys.exit(f"FAILED: {ended}")
    _, _, text = running.request("GET", f"{path}/rotor.py?ross={version}")
    return text if isinstance(text, str) else text.decode()


def by_ross(script, asked):
    with tempfile.TemporaryDirectory() as directory:
        names = [os.path.join(directory, name) for name in ("exported.py", "driver.py")]
        for name, text in zip(names, (script, DRIVER)):
            with open(name, "w", encoding="utf-8") as file:
                file.write(text)
        ran = subprocess.run([python(), names[1], names[0], json.dumps(asked)], capture_output=True, text=True, timeout=600)
    if ran.returncode != 0:
        sys.exit(f"FAILED: the exported script\n{ran.stderr}")
    return json.loads(ran.stdout.splitlines()[-1])


def largest_difference(ours, theirs):
    """Largest relative distance of one of our values from the nearest of theirs, which also have axial and torsional modes."""
    return max(min(abs(one - other) for other in theirs) / one for one in ours)


def compare(running, job, name):
    answer = result(running, job, "rotor")
    speeds = [rpm * 3.141592653589793 / 30 for rpm in answer["speeds_rpm"]]
    criticals = [critical["speed_rpm"] * 3.141592653589793 / 30 for critical in answer["criticals"]]
    disc = answer["model"]["discs"][0]["node"]
    theirs = by_ross(script_of(running, job, 2), {"speeds": speeds, "criticals": criticals, "nodes": [disc]})
    worst = 0
    for index in range(len(speeds)):
        ours = [2 * 3.141592653589793 * mode["frequency_hz"][index] for mode in answer["modes"]]
        worst = max(worst, largest_difference(ours, theirs["speeds"][index]))
    verdict(worst < 1e-6, f"{name}: natural frequencies at {len(speeds)} speeds differ by {worst:.1e} of ROSS at most")
    worst = max(largest_difference([speed], found) for speed, found in zip(criticals, theirs["criticals"]))
    verdict(len(criticals) >= 2 and worst < 1e-6, f"{name}: {len(criticals)} critical speeds differ by {worst:.1e}")
    station = next(one for one in answer["response"] if abs(one["at_mm"] - job["scene"]["shaft"]["discs"][0]["at_mm"]) < 1e-6)
    pairs = [(ours * 1e-6, other) for axis, along in (("y_um", 0), ("z_um", 1))
             for ours, other in zip(station[axis], theirs["response"][0][along]) if other > 0]
    worst = max(abs(ours / other - 1) for ours, other in pairs)
    verdict(len(pairs) >= 8 and worst < 1e-5, f"{name}: unbalance response differs by {worst:.1e}")


def case_disc_in_the_middle(running):
    compare(running, MIDDLE, "disc in the middle")


def case_overhung_disc(running):
    compare(running, OVERHUNG, "overhung disc")


def case_argument_of_the_tables(running):
    """ROSS 3 renames the argument of tabulated coefficients."""
    names = {version: set(re.findall(r", (frequency|speed)=", script_of(running, MIDDLE, version))) for version in (2, 3)}
    verdict(names == {2: {"frequency"}, 3: {"speed"}}, f"tables over {names[2]} for ROSS 2, over {names[3]} for ROSS 3")


def bearings():
    return [{"name": name, "bearing": "6205", "at_mm": at, "faces": faces} for name, at, faces in (("A", 40, "+x"), ("B", 260, "-x"))]


def calls_of_ross(script):
    """Pairs of the recorded name of each call of ROSS in a script, such as `Rotor.run_modal`, and the call. What is called by its bare name has
    to be a function of the script or of Python."""
    nodes = list(ast.walk(ast.parse(script)))
    imported = [name for node in nodes if isinstance(node, ast.Import) for name in node.names]
    own = {node.name for node in nodes if isinstance(node, ast.FunctionDef)} | set(dir(builtins))
    # Names of the script that are ROSS or one of its objects, and how the record names them.
    known = {name.asname or name.name: "" for name in imported if name.name == "ross"}

    def recorded(call):
        root, _, rest = ast.unparse(call.func).partition(".")
        return known[root] + rest if root in known else None

    for node in nodes:
        if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call) and recorded(node.value):
            known |= {target.id: f"{recorded(node.value)}." for target in node.targets}
    calls = [node for node in nodes if isinstance(node, ast.Call)]
    unknown = {call.func.id for call in calls if isinstance(call.func, ast.Name)} - own
    if unknown:
        sys.exit(f"FAILED: the script calls {unknown}, which it does not define")
    return [(recorded(call), call) for call in calls if recorded(call)]


def faults_of(script, signatures):
    """What the calls of ROSS in a script do against the recorded signatures, and the names that it calls."""
    faults, called = set(), set()
    for name, call in calls_of_ross(script):
        called.add(name)
        if name not in signatures:
            faults.add(f"{name} is not recorded")
            continue
        required, optional = (signatures[name][kind] for kind in ("required", "optional"))
        names, given = required + optional, [keyword.arg for keyword in call.keywords]
        by_place = names[:len(call.args)]
        if len(call.args) > len(names):
            faults.add(f"{name} takes {len(names)} arguments, not {len(call.args)}")
        faults |= {f"{name} takes no {keyword}" for keyword in given if keyword not in names}
        faults |= {f"{name} gets {keyword} twice" for keyword in given if keyword in by_place}
        faults |= {f"{name} needs {missing}" for missing in required if missing not in by_place + given}
    return sorted(faults), called


def case_signatures_of_ross_3(running):
    """ROSS 3 needs Python 3.13, so that its script is read and not run: with constant supports, and with tables of bearings."""
    with open(SIGNATURES, encoding="utf-8") as file:
        record = json.load(file)
    loaded = {"supports": [], "bearings": bearings(), "operation": {"speed_rpm": 12000, "radial_load_y_n": 500, "axial_load_n": 100}}
    for name, job in (("supports", MIDDLE), ("bearings", MIDDLE | {"scene": MIDDLE["scene"] | loaded})):
        script = script_of(running, job, 3)
        faults, called = faults_of(script, record["calls"])
        told = "; ".join(faults) or f"calls {len(called)} names with arguments of that version"
        verdict(not faults and called == set(record["calls"]), f"script with {name} for ROSS {record['version']}: {told}")
        spoilt = set(faults_of(script.replace(" odl=", " outer="), record["calls"])[0]) - set(faults)
        verdict(spoilt == {"ShaftElement takes no outer", "ShaftElement needs odl"}, f"a wrong name is found: {', '.join(sorted(spoilt))}")


def case_turning_outer_rings(running):
    """Tables of the bearings are those of the result, which depend on the speed of the outer rings."""
    def tables(outer):
        scene = MIDDLE["scene"] | {"supports": [], "bearings": bearings(),
                                   "operation": {"speed_rpm": 12000, "outer_speed_rpm": outer, "radial_load_y_n": 500}}
        job = MIDDLE | {"scene": scene}
        listed = [json.loads(text) for text in re.findall(r"kxx=(\[[^]]*\])", script_of(running, job, 2))]
        ours = [[k[1][1] for k in support["k"]] for support in result(running, job, "rotor")["model"]["supports"]]
        verdict(len(listed) == 2 and listed == ours, f"tables of bearings with outer rings at {outer} r/min are those of the result")
        return listed

    verdict(tables(0) != tables(12000), "tables of bearings depend on the speed of the outer rings")


def case_rigid_spindles_have_no_script(running):
    job = {"kind": "rotor", "scene": {"bearings": bearings(), "operation": {"speed_rpm": 6000, "radial_load_y_n": 500}}}
    path, _ = running.submit(job)
    running.ended(path)
    status, _, answer = running.request("GET", f"{path}/rotor.py")
    verdict(status == 400 and "rigid spindle" in answer.get("detail", ""), f"a rigid spindle has no script: {status} {answer.get('detail')}")


if __name__ == "__main__":
    run_cases(globals())
