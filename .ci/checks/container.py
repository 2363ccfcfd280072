#!/usr/bin/env python3
"""The Dockerfile without a container engine: its command, as its user, with /data as the only writable folder."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ARTICLE, ROOT, Service, binary, check, free_port  # noqa: E402

with open(os.path.join(ROOT, "Dockerfile"), encoding="utf-8") as file:
    text = re.sub(r"\\\n\s*", "", file.read())


def instruction(name):
    return [line.split(None, 1)[1] for line in text.splitlines() if line.startswith(name + " ")][-1]


entry, arguments = json.loads(instruction("ENTRYPOINT")), json.loads(instruction("CMD"))
health = json.loads(instruction("HEALTHCHECK").split(" CMD ", 1)[1])
user = instruction("USER")
uid = int(user.split(":")[0])
check(entry == ["raceway"] and uid > 0, f"the entry point is raceway, the user is {user}")
bases = [line.split()[1] for line in text.splitlines() if line.startswith("FROM ")]
for base, digest in zip(bases, ("RUST_DIGEST", "DEBIAN_DIGEST"), strict=True):
    check(base.endswith(f"${{{digest}:+@${digest}}}"), f"the base image {base} takes {digest}")
    check(text.index(f"ARG {digest}\n") < text.index("FROM "), f"{digest} is declared for all stages")
with open(os.path.join(ROOT, ".dockerignore"), encoding="utf-8") as file:
    let_in = {line[1:] for line in file.read().splitlines() if line.startswith("!")}
with tempfile.TemporaryDirectory(prefix="raceway-context-") as context:
    for source in re.findall(r"^COPY (?!--from)(.+) \S+$", text, re.MULTILINE):
        for path in source.split():
            check(path in let_in, f".dockerignore admits {path}")
            if os.path.isdir(os.path.join(ROOT, path)):
                shutil.copytree(os.path.join(ROOT, path), os.path.join(context, path))
            else:
                shutil.copy(os.path.join(ROOT, path), context)
    # In place of a second build: every file that the manifest or the code names is copied.
    with open(os.path.join(context, "Cargo.toml"), "rb") as file:
        manifest = tomllib.load(file)
    for kind, folder in (("bench", "benches"), ("test", "tests"), ("example", "examples")):
        for name in (target["name"] for target in manifest.get(kind, [])):
            there = [os.path.join(context, folder, end) for end in (f"{name}.rs", f"{name}/main.rs")]
            check(any(map(os.path.exists, there)), f"the {kind} {name}, which Cargo.toml names, is copied")
    # A path dependency is copied with its manifest and its code.
    paths = [table["path"] for table in manifest["dependencies"].values() if isinstance(table, dict) and "path" in table]
    members = manifest["workspace"]["members"]
    check(set(paths) <= set(members), "path dependencies are members of the workspace")
    for path in members:
        there = [os.path.join(context, path, end) for end in ("Cargo.toml", "src/lib.rs")]
        check(all(map(os.path.exists, there)), f"the member {path} is copied")
    for place, _, names in os.walk(context):
        for name in names:
            if not name.endswith(".rs"):
                continue
            with open(os.path.join(place, name), encoding="utf-8") as source:
                included = re.findall(r'include_(?:str|bytes)!\("([^"]+)"\)', source.read())
            for file in included:
                check(os.path.exists(os.path.join(place, file)), f"{file}, which the code includes, is copied")

libraries = subprocess.run(["ldd", binary()], capture_output=True, text=True, check=True).stdout
needed = {os.path.basename(line.split()[0]).split(".so")[0] for line in libraries.splitlines() if ".so" in line}
slim = {"linux-vdso", "libgcc_s", "libm", "libc", "ld-linux-x86-64", "ld-linux-aarch64"}
check(needed <= slim, f"the binary needs only libraries of a slim Debian ({', '.join(sorted(needed))})")

place = tempfile.mkdtemp(prefix="raceway-container-")
try:
    os.chmod(place, 0o755)
    program, data = os.path.join(place, "raceway"), os.path.join(place, "data")
    shutil.copy(binary(), program)
    os.chmod(program, 0o755)
    os.mkdir(data, 0o750)
    as_user = []
    if os.geteuid() == 0:
        os.chown(data, uid, uid)
        as_user = ["setpriv", "--reuid", str(uid), "--regid", str(uid), "--clear-groups", "--no-new-privs"]
    port = str(free_port())

    def in_container(words):
        return [word.replace("8080", port).replace("/data", data) for word in words]

    token = "a-token-for-this-check"
    environment = {"PATH": "/usr/bin:/bin", "RACEWAY_API_TOKENS": token}
    command = as_user + [program] + in_container(arguments)
    bare = subprocess.run(command, env={"PATH": "/usr/bin:/bin"}, cwd="/", capture_output=True, timeout=20)
    check(bare.returncode != 0, "without tokens the container does not start")
    running = Service(place, command=command, environment=environment, cwd="/")
    running.token = token
    try:
        owner = os.stat(f"/proc/{running.process.pid}").st_uid
        check(owner == (uid if as_user else os.geteuid()), f"the service runs as {owner}")
        probe = as_user + [program] + in_container(health[1:])
        asked = subprocess.run(probe, env={"PATH": "/usr/bin:/bin"}, cwd="/", capture_output=True, timeout=10)
        check(asked.returncode == 0, "the health check succeeds")
        path, _ = running.submit(ARTICLE | {"duration_s": 0.01, "settle_s": 0})
        check(running.ended(path)["status"] == "succeeded", "a job succeeds")
        check(os.path.exists(os.path.join(data, "raceway.db")), "the database lies in /data")
    finally:
        status = running.stop()
    check(status == 0, "it stops with status 0 on SIGTERM")
    asked = subprocess.run(probe, env={"PATH": "/usr/bin:/bin"}, cwd="/", capture_output=True, timeout=10)
    check(asked.returncode != 0, "the health check of a stopped service fails")
finally:
    shutil.rmtree(place)
