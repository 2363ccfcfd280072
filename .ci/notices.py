#!/usr/bin/env python3
"""Prints the licences of the crates and of the plot library in the binary, with their texts. Equal texts stand once."""

import pathlib
import re
import sys

import sbom

# Files with a licence or a notice, by their names.
NAMED = re.compile(r"(licen[sc]e|copying|copyright|notice|unlicense)", re.IGNORECASE)


def texts(folder):
    """Texts of the licence files of a package."""
    files = sorted(path for path in folder.iterdir() if path.is_file() and NAMED.match(path.name) and path.suffix != ".rs")
    return [path.read_text(encoding="utf-8", errors="replace").strip() for path in files]


def main():
    packages, nodes, root = sbom.graph()
    linked = sorted((packages[one] for one in sbom.reachable(nodes, root, {None}) - {root}), key=lambda one: one["name"])
    print("Parts of the binary raceway and their licences. The texts follow.\n")
    users = {}
    for package in linked:
        name = f"{package['name']} {package['version']}"
        print(f"{name}: {package['license']}")
        for text in texts(pathlib.Path(package["manifest_path"]).parent):
            users.setdefault(text, []).append(name)
    plot_library = sbom.vendored()
    print(f"{plot_library['name']} {plot_library['version']}: {plot_library['licenses'][0]['expression']}")
    vendor = pathlib.Path(sbom.ROOT, "src", "api", "portal", "vendor")
    for text in texts(vendor):
        users.setdefault(text, []).append(plot_library["name"])
    for text, names in users.items():
        print(f"\n{'-' * 80}\n{', '.join(dict.fromkeys(names))}\n\n{text}")


if __name__ == "__main__":
    sys.exit(main())
