#!/usr/bin/env python3
"""The program writes docs/ARTICLE.md, figure by figure. Sampled sets of parameters give a report and a table."""

import os
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir))
from service import binary, check  # noqa: E402

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"


def article(directory, *arguments):
    done = subprocess.run([binary(), "article", "--quiet", "--output", directory, *arguments], text=True, capture_output=True, timeout=600)
    if done.returncode:
        sys.exit(done.stderr)


def sections(path):
    """Text of each figure, by its heading."""
    parts = path.read_text().split("\n## ")[1:]
    return {part.split("\n", 1)[0]: part for part in parts}


with tempfile.TemporaryDirectory(prefix="raceway-check-") as directory:
    written = pathlib.Path(directory)
    published = sections(DOCS / "ARTICLE.md")
    for figure in ("9", "14"):
        article(directory, "--figure", figure)
        for title, text in sections(written / f"FIGURE-{figure}.md").items():
            check(text.strip() == published[title].strip(), f"docs/ARTICLE.md is what the program writes: {title}")
    for picture in (written / "plots" / "article").iterdir():
        check(picture.read_text() == (DOCS / "plots" / "article" / picture.name).read_text(), f"so is {picture.name}")
    article(directory, "--robustness", "--sets", "3", "--seed", "1")
    rows = (written / "robustness.csv").read_text().splitlines()
    check(len(rows) == 4 and all(row.count(",") == rows[0].count(",") for row in rows), "three sampled sets make three rows")
    check("| 13, axial preload" in (written / "ROBUSTNESS.md").read_text(), "and a report on each statement")
