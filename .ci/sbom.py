#!/usr/bin/env python3
"""Prints the bill of materials of the binary: CycloneDX 1.5, from Cargo.lock. The same lock file gives the same bytes.

It lists the crates of the binary with their procedural macros, build dependencies (scope `excluded`), and the plot library of
the page. Crates that only tests use are left out."""

import hashlib
import json
import os
import re
import subprocess
import sys
import tomllib
import uuid

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
TARGET = "x86_64-unknown-linux-gnu"
# Namespace of this project's serial numbers.
NAMESPACE = uuid.uuid5(uuid.NAMESPACE_URL, "urn:raceway:sbom")


def read(name):
    with open(os.path.join(ROOT, name), "rb") as file:
        return file.read()


def direct(node, kinds):
    """Ids of the packages on which a node depends by one of these kinds (None: normal)."""
    return {dependency["pkg"] for dependency in node["deps"] if any(kind["kind"] in kinds for kind in dependency["dep_kinds"])}


def reachable(nodes, start, kinds):
    """Ids of the packages that are reached from `start` over dependencies of these kinds."""
    seen, waiting = set(), {start}
    while waiting:
        package = waiting.pop()
        seen.add(package)
        waiting |= direct(nodes[package], kinds) - seen
    return seen


def purl(package):
    return f"pkg:cargo/{package['name']}@{package['version']}"


def component(package, checksums, linked):
    described = {
        "type": "library", "bom-ref": purl(package), "name": package["name"], "version": package["version"],
        "purl": purl(package), "scope": "required" if linked else "excluded",
    }
    if package["license"]:
        # Older manifests write `/` for OR.
        described["licenses"] = [{"expression": re.sub(r"\s*/\s*", " OR ", package["license"])}]
    checksum = checksums.get((package["name"], package["version"]))
    if checksum:
        described["hashes"] = [{"alg": "SHA-256", "content": checksum}]
    if package["repository"]:
        described["externalReferences"] = [{"type": "vcs", "url": package["repository"]}]
    return described


def vendored():
    """The plot library of the page, which lies in the repository."""
    content = read("src/api/portal/vendor/uPlot.esm.js")
    version = re.search(rb"v(\d+\.\d+\.\d+)", content).group(1).decode()
    reference = f"pkg:npm/uplot@{version}"
    return {
        "type": "library", "bom-ref": reference, "name": "uPlot", "version": version, "purl": reference, "scope": "required",
        "licenses": [{"expression": "MIT"}], "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(content).hexdigest()}],
    }


def graph():
    """Packages and nodes of the dependencies by id, and the id of the root."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", TARGET]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout)
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    return packages, nodes, metadata["resolve"]["root"]


def bill():
    packages, nodes, root = graph()
    used = {None, "build"}
    linked, all_used = reachable(nodes, root, {None}), reachable(nodes, root, used)
    lock = read("Cargo.lock")
    checksums = {(entry["name"], entry["version"]): entry.get("checksum") for entry in tomllib.loads(lock.decode())["package"]}

    others = sorted(all_used - {root}, key=lambda package: purl(packages[package]))
    components = [component(packages[package], checksums, package in linked) for package in others] + [vendored()]
    dependencies = []
    for package in [root, *others]:
        needed = {purl(packages[dependency]) for dependency in direct(nodes[package], used)}
        needed |= {components[-1]["bom-ref"]} if package == root else set()
        dependencies.append({"ref": purl(packages[package]), "dependsOn": sorted(needed)})
    itself = component(packages[root], checksums, True) | {"type": "application"}
    del itself["scope"]
    return {
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "serialNumber": f"urn:uuid:{uuid.uuid5(NAMESPACE, hashlib.sha256(lock).hexdigest())}",
        "metadata": {"component": itself},
        "components": components,
        "dependencies": dependencies,
    }


if __name__ == "__main__":
    json.dump(bill(), sys.stdout, indent=1)
    print()
