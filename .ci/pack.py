#!/usr/bin/env python3
"""Files of a release, from parts that exist already.

    pack.py binary BINARY FOLDER [--sbom FILE] [--notices FILE]    wheel and archive of a binary
    pack.py npm FOLDER                                             package for npm, compiled with the tools of .ci/checks/api

The system of a binary is read from the binary. The same parts give the same files."""

import argparse
import gzip
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tarfile
import tempfile

CI = pathlib.Path(__file__).resolve().parent
ROOT = CI.parent
sys.path[:0] = [str(CI), str(ROOT / "packages" / "python")]
import backend  # noqa: E402

# Tracked files beside the binary.
DOCUMENTS = ["README.md", "OPERATIONS.md", "CHANGELOG.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "LICENSE-MIT", "LICENSE-APACHE",
             "docs", "examples", "openapi"]


def system(tag):
    """Name of a system in the archive's name, by the platform tag of the wheel."""
    name, _, machine = tag.partition("_")
    machine = "aarch64" if machine.endswith("arm64") or machine.endswith("aarch64") else "x86_64"
    return f"{machine}-{ {'manylinux': 'linux', 'macosx': 'macos', 'win': 'windows'}[name] }"


def archive(binary, folder, extra, level=9):
    """Writes the archive of a binary with documents and licences, compressed at a level from 1 to 9, and returns its path."""
    stem = f"raceway-{backend.version()}-{system(backend.platform(binary))}"
    name = "raceway.exe" if stem.endswith("windows") else "raceway"
    tracked = subprocess.run(["git", "ls-files", "-z", "--", *DOCUMENTS], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    files = {name: binary} | {name: ROOT / name for name in tracked.stdout.split("\0") if name} | extra
    path = folder / f"{stem}.tar.gz"
    with open(path, "wb") as file, gzip.GzipFile(filename="", fileobj=file, mode="wb", compresslevel=level, mtime=0) as zipped:
        with tarfile.open(fileobj=zipped, mode="w", format=tarfile.PAX_FORMAT) as tar:
            for name, source in files.items():
                content = source.read_bytes()
                entry = tarfile.TarInfo(f"{stem}/{name}")
                entry.size, entry.mode = len(content), 0o755 if os.access(source, os.X_OK) else 0o644
                tar.addfile(entry, io.BytesIO(content))
    return path


def npm(folder):
    """Compiles the package for npm in a copy, packs it, and returns its path."""
    import api_tools

    api_tools.install_node()
    with tempfile.TemporaryDirectory(prefix="raceway-npm-") as place:
        source = pathlib.Path(place, "packages", "npm")
        shutil.copytree(ROOT / "packages" / "npm", source, ignore=shutil.ignore_patterns("node_modules", "dist", "schema.ts"))
        shutil.copytree(ROOT / "openapi", pathlib.Path(place, "openapi"))
        for licence in ("LICENSE-MIT", "LICENSE-APACHE"):
            shutil.copy(ROOT / licence, source)
        described = json.loads((source / "package.json").read_text(encoding="utf-8"))
        if described["version"] != backend.version():
            raise SystemExit(f"packages/npm/package.json has version {described['version']}, Cargo.toml {backend.version()}")
        search = os.path.dirname(api_tools.tool("tsc")) + os.pathsep + os.environ["PATH"]
        quiet = {"env": api_tools.clean_environment(PATH=search), "cwd": source, "check": True, "stdout": subprocess.PIPE, "text": True}
        subprocess.run(["npm", "run", "--silent", "build"], **quiet)
        packed = subprocess.run(["npm", "pack", "--silent", "--pack-destination", folder.resolve()], **quiet)
        return folder / packed.stdout.strip()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parts = parser.add_subparsers(dest="part", required=True)
    of_binary = parts.add_parser("binary")
    of_binary.add_argument("binary", type=pathlib.Path)
    of_binary.add_argument("folder", type=pathlib.Path)
    of_binary.add_argument("--sbom", type=pathlib.Path)
    of_binary.add_argument("--notices", type=pathlib.Path)
    parts.add_parser("npm").add_argument("folder", type=pathlib.Path)
    given = parser.parse_args()
    if given.part == "npm":
        print(npm(given.folder))
        return
    extra = {"sbom": given.sbom, "notices": given.notices}
    in_wheel = {"sbom": "sboms/raceway.cdx.json", "notices": "licenses/THIRD-PARTY-NOTICES"}
    in_archive = {"sbom": "raceway.cdx.json", "notices": "THIRD-PARTY-NOTICES"}
    print(backend.wheel(given.binary, given.folder, {in_wheel[part]: path for part, path in extra.items() if path}))
    print(archive(given.binary, given.folder, {in_archive[part]: path for part, path in extra.items() if path}))


if __name__ == "__main__":
    main()
