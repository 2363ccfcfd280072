"""Build backend of pyproject.toml (PEP 517): the wheel, from a binary that exists already.

The platform of the wheel is read from the binary. For Linux it is the newest version of glibc that the binary needs. The same
files give the same wheel. `pip wheel packages/python` takes the binary from the variable RACEWAY, else from target/release."""

from __future__ import annotations

import base64
import csv
import hashlib
import io
import json
import os
import pathlib
import re
import subprocess
import sys
import tomllib
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE))
import typed_dicts  # noqa: E402

#: Libraries that every Linux with glibc has.
COMMON = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1", "libgcc_s.so.1", "ld-linux-x86-64.so.2",
          "ld-linux-aarch64.so.1"}
MACHINES = {"Advanced Micro Devices X86-64": "x86_64", "AArch64": "aarch64"}


def version() -> str:
    """Version of the workspace."""
    return tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]


def platform(binary: pathlib.Path) -> str:
    """Platform tag of a binary, by its format."""
    head = binary.read_bytes()[:64]
    if head.startswith(b"MZ"):
        return "win_amd64"
    if head.startswith(b"\xcf\xfa\xed\xfe"):
        # Mach-O, 64 bits: the type of the processor stands behind the magic number. Rust's oldest macOS for each.
        return "macosx_11_0_arm64" if head[4] == 0x0C else "macosx_10_12_x86_64"
    return _linux(binary)


def _linux(binary: pathlib.Path) -> str:
    """`manylinux_2_28_x86_64` for a binary that needs glibc 2.28."""
    command = ["readelf", "--wide", "--file-header", "--dynamic", "--version-info", str(binary)]
    told = subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, "LC_ALL": "C"}).stdout
    machine = MACHINES[re.search(r"Machine:\s+(.+)", told).group(1).strip()]
    others = set(re.findall(r"\(NEEDED\)\s+Shared library: \[(.+?)\]", told)) - COMMON
    if others:
        raise SystemExit(f"{binary} needs libraries that not every Linux has: {', '.join(sorted(others))}")
    needed = {tuple(map(int, one.split("."))) for one in re.findall(r"Name: GLIBC_(\d+\.\d+)", told)}
    major, minor = max(needed)
    return f"manylinux_{major}_{minor}_{machine}"


def wheel(binary: pathlib.Path, folder: pathlib.Path, extra: dict[str, pathlib.Path] | None = None, level: int = 9) -> pathlib.Path:
    """Writes the wheel, compressed at a level from 1 to 9, and returns its path. `extra` are further files of the dist-info
    folder."""
    project = tomllib.loads((HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    tag = f"py3-none-{platform(binary)}"
    stem = f"{project['name']}-{version()}"
    info = f"{stem}.dist-info"
    files = {f"raceway/{path.name}": path.read_bytes() for path in sorted((HERE / "raceway").glob("*.py"))}
    files["raceway/py.typed"] = b""
    files["raceway/schema.py"] = schema()
    name = "raceway.exe" if tag.endswith("win_amd64") else "raceway"
    files[f"raceway/bin/{name}"] = binary.read_bytes()
    files[f"{info}/METADATA"] = metadata(project)
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: raceway\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    scripts = "".join(f"{name} = {place}\n" for name, place in project["scripts"].items())
    files[f"{info}/entry_points.txt"] = f"[console_scripts]\n{scripts}".encode()
    for licence in ("LICENSE-MIT", "LICENSE-APACHE"):
        files[f"{info}/licenses/{licence}"] = (ROOT / licence).read_bytes()
    files |= {f"{info}/{name}": path.read_bytes() for name, path in (extra or {}).items()}
    files[f"{info}/RECORD"] = record(files, f"{info}/RECORD")
    path = folder / f"{stem}-{tag}.whl"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if name.startswith("raceway/bin/") else 0o100644) << 16
            archive.writestr(entry, content, compresslevel=level)
    return path


def schema() -> bytes:
    """The module with the types of the API."""
    document = json.loads((ROOT / "openapi" / "openapi.json").read_text(encoding="utf-8"))
    return typed_dicts.module(document).encode()


def metadata(project: dict) -> bytes:
    """Core metadata 2.4."""
    lines = ["Metadata-Version: 2.4", f"Name: {project['name']}", f"Version: {version()}", f"Summary: {project['description']}",
             f"License-Expression: {project['license']}", "License-File: LICENSE-MIT", "License-File: LICENSE-APACHE",
             f"Requires-Python: {project['requires-python']}"]
    for extra, packages in project["optional-dependencies"].items():
        lines.append(f"Provides-Extra: {extra}")
        lines += [f'Requires-Dist: {package} ; extra == "{extra}"' for package in packages]
    text = (HERE / project["readme"]).read_text(encoding="utf-8")
    return "\n".join([*lines, "Description-Content-Type: text/markdown", "", text]).encode()


def record(files: dict[str, bytes], itself: str) -> bytes:
    """Digest and length of each file."""
    table = io.StringIO()
    rows = csv.writer(table, lineterminator="\n")
    for name, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        rows.writerow([name, f"sha256={digest}", len(content)])
    rows.writerow([itself, "", ""])
    return table.getvalue().encode()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Hook of PEP 517."""
    target = os.environ.get("CARGO_TARGET_DIR", ROOT / "target")
    binary = pathlib.Path(os.environ.get("RACEWAY", pathlib.Path(target, "release", "raceway")))
    if not binary.exists():
        raise SystemExit(f"{binary} does not exist; build it with: cargo build --release")
    return wheel(binary, pathlib.Path(wheel_directory)).name


def build_sdist(sdist_directory, config_settings=None):
    """Hook of PEP 517."""
    raise SystemExit("raceway has no source distribution: its sources are the repository")
