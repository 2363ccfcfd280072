#!/usr/bin/env python3
"""The reference pages are those that openapi/openapi.json gives; links between documents lead somewhere."""

import os
import pathlib
import re
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import ROOT, check  # noqa: E402

ROOT = pathlib.Path(ROOT)
done = subprocess.run([sys.executable, ROOT / "docs/reference/generate.py", "--check"], capture_output=True, text=True)
check(done.returncode == 0, f"docs/reference is what openapi/openapi.json says {done.stderr.strip()}")


def anchors(text):
    """Anchors of the headings, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S), re.M)
    plain = (re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower() for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in plain}


listed = subprocess.run(["git", "-C", ROOT, "ls-files", "*.md"], capture_output=True, text=True, check=True).stdout.split()
texts = {ROOT / name: (ROOT / name).read_text(encoding="utf-8") for name in listed if "/vendor/" not in name}
broken = []
for page, text in texts.items():
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        if not file.exists() or anchor and file in texts and anchor not in anchors(texts[file]):
            broken.append(f"{page.relative_to(ROOT)}: {target}")
check(not broken, f"{len(texts)} documents link to what exists {broken}")
