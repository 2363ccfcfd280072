#!/usr/bin/env python3
"""The supply chain: rules for dependencies, known faults from a local database, the bill of materials, and the release script."""

import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, binary, check  # noqa: E402

CI = pathlib.Path(ROOT, ".ci")
TARGET = os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target"))
RULES = pathlib.Path(ROOT, "deny.toml").read_text(encoding="utf-8")
IDENTITY = ["-c", "user.name=check", "-c", "user.email=check@example.org"]
DIGESTS = {"RUST_DIGEST": "sha256:" + "1a" * 32, "DEBIAN_DIGEST": "sha256:" + "2b" * 32}

ADVISORY = """```toml
[advisory]
id = "RUSTSEC-2026-0001"
package = "{crate}"
date = "2026-01-01"

[versions]
patched = [">= {patched}"]
```

# A fault

It is made up.
"""


def run(*command, cwd=ROOT, **environment):
    done = subprocess.run(
        list(map(str, command)), cwd=cwd, capture_output=True, text=True, env=os.environ | {"CARGO_TARGET_DIR": TARGET} | environment)
    return done.returncode, done.stdout, done.stderr


def case_dependencies_keep_the_rules(place):
    status, _, said = run(CI / "cargo-deny", "check", "--hide-inclusion-graph", "bans", "licenses", "sources")
    check(status == 0, f"cargo deny accepts bans, licences and sources {said if status else ''}")
    breaches = {
        "bans": ('    { crate = "base64@0.22", reason = "sqlx" },\n', ""),
        "licenses": ('"MIT", ', ""),
        "sources": ("[sources]\n", "[sources]\nallow-registry = []\n"),
    }
    for name, (held, changed) in breaches.items():
        check(RULES.count(held) == 1, f"deny.toml has {held.strip()}")
        stricter = place / f"{name}.toml"
        stricter.write_text(RULES.replace(held, changed), encoding="utf-8")
        status, _, _ = run(CI / "cargo-deny", "--config", stricter, "check", "--hide-inclusion-graph", name)
        check(status != 0, f"a stricter rule of {name} is broken")


def case_known_faults_are_found(place):
    database = place / "advisories"
    subprocess.run(["git", "init", "-q", "-b", "main", database], check=True)
    for patched, expected in (("0.0.1", 0), ("999.0.0", 1)):
        entry = database / "crates" / "subtle" / "RUSTSEC-2026-0001.md"
        entry.parent.mkdir(parents=True, exist_ok=True)
        entry.write_text(ADVISORY.format(crate="subtle", patched=patched), encoding="utf-8")
        subprocess.run(["git", "-C", database, "add", "."], check=True)
        subprocess.run(["git", "-C", database, *IDENTITY, "commit", "-qm", f"patched in {patched}"], check=True)
        status, _, said = run(CI / "advisories", database)
        named = "RUSTSEC-2026-0001" in said
        check(status == expected and named == bool(expected), f"a fault mended in {patched}: status {status} {said if status > 1 else ''}")


def case_the_bill_of_materials_is_complete(_place):
    (status, text, said), (_, again, _) = run(CI / "sbom.py"), run(CI / "sbom.py")
    check(status == 0 and text == again, f"the same lock file gives the same bill {said if status else ''}")
    bill = json.loads(text)
    check((bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.5"), "it is CycloneDX 1.5")
    parts = {part["bom-ref"]: part for part in bill["components"]}
    known = set(parts) | {bill["metadata"]["component"]["bom-ref"]}
    check(len(parts) == len(bill["components"]), f"it lists {len(parts)} components once")
    named = {entry["ref"] for entry in bill["dependencies"]} | {to for entry in bill["dependencies"] for to in entry["dependsOn"]}
    check(named == known, "every component has its place in the graph")
    check(all(part["licenses"] for part in parts.values()), "every component has its licence")
    with open(os.path.join(ROOT, "Cargo.lock"), "rb") as file:
        locked = {(entry["name"], entry["version"]): entry.get("checksum") for entry in tomllib.load(file)["package"]}
    crates = [part for part in parts.values() if part["purl"].startswith("pkg:cargo/")]
    wrong = [
        part["name"] for part in crates
        if part.get("hashes", [{"content": None}])[0]["content"] != locked[part["name"], part["version"]]
    ]
    check(not wrong, f"{len(crates)} digests are those of Cargo.lock {wrong}")


def case_a_release_needs_the_digests_of_its_base_images(place):
    """On a clone of the last commit, with a stub for the container engine. It packs the release build in place of a build with zig."""
    clone, engine = place / "clone", place / "engine"
    subprocess.run(["git", "clone", "-q", ROOT, clone], check=True)
    engine.write_text('#!/bin/sh\necho "$@" >>"$0.log"\n[ "$1" != save ] || echo image >"$3"\n', encoding="utf-8")
    engine.chmod(0o755)
    environment = {"ENGINE": str(engine), "CARGO_TARGET_DIR": str(place / "target"), "BINARY": binary()}
    (place / "target").mkdir()
    for tools in ("tools", "api-tools"):
        os.makedirs(os.path.join(TARGET, tools), exist_ok=True)
        (place / "target" / tools).symlink_to(os.path.join(TARGET, tools))
    for name in DIGESTS:
        for wrong in ("", "latest", "sha256:12"):
            status, _, said = run(clone / ".ci" / "release", cwd=clone, **environment, **DIGESTS | {name: wrong})
            check(status == 2 and name in said, f"{name}={wrong} is refused")
    status, told, said = run(clone / ".ci" / "release", cwd=clone, **environment, **DIGESTS)
    check(status == 0, f"with both digests a release is made {said if status else ''}")
    log = (place / "engine.log").read_text(encoding="utf-8")
    check(all(f"--build-arg {name}={digest}" in log for name, digest in DIGESTS.items()), "the image is built from both digests")
    sums = dict(reversed(line.split()) for line in told.splitlines() if line.count(" ") == 2)
    files = {path.name: path.read_bytes() for path in (place / "target" / "dist").iterdir() if path.name != "SHA256SUMS"}
    check({name: hashlib.sha256(content).hexdigest() for name, content in files.items()} == sums, f"{sorted(files)} have their digests")
    for pattern in ("raceway-*.whl", "raceway-*.tgz", "raceway-*-x86_64-linux.tar.gz", "raceway-*.cdx.json", "THIRD-PARTY-NOTICES"):
        check(len(list((place / "target" / "dist").glob(pattern))) == 1, f"{pattern} is among them")
    notices = files["THIRD-PARTY-NOTICES"].decode()
    check("axum 0." in notices and "uPlot" in notices and "Permission is hereby granted" in notices, "the licences of the parts have their texts")
    (clone / "Cargo.toml").write_text("", encoding="utf-8")
    status, _, said = run(clone / ".ci" / "release", cwd=clone, **environment, **DIGESTS)
    check(status == 2 and "not committed" in said, "a changed work tree is refused")
    status, _, said = run(clone / ".ci" / "release", "--without-image", cwd=clone, **environment)
    check(status == 2 and "not committed" in said, "also without image, which needs no digests")


with tempfile.TemporaryDirectory(prefix="raceway-supply-") as directory:
    for case in (
        case_dependencies_keep_the_rules,
        case_known_faults_are_found,
        case_the_bill_of_materials_is_complete,
        case_a_release_needs_the_digests_of_its_base_images,
    ):
        case(pathlib.Path(directory))
