#!/usr/bin/env python3
"""Writes the short tables of the pages from the data files in this folder.

    tables.py            rewrites every table that differs
    tables.py --check    changes nothing; exit status 1 if a table differs

A page holds a table between two comments:

    <!-- table: FILE.csv; columns: NAME = Heading, NAME; where: NAME = VALUE, NAME = VALUE -->
    <!-- end -->

`columns` selects and renames columns (default: all), `where` selects rows. `count: ROWS by COLUMNS` prints, in place of the
rows, how many rows of the file have each pair of values of the two columns. A data file is CSV; lines that begin with `#`
state what was measured, by which command, when and on which machine. A table has at most 12 rows.
"""
import csv
import pathlib
import re
import sys

DATA = pathlib.Path(__file__).resolve().parent
DOCS = DATA.parent
MOST_ROWS = 12
BLOCK = re.compile(r"(<!-- table: (?P<options>[^\n]*?) -->\n)(?P<table>.*?)(<!-- end -->)", re.S)


def read(name):
    lines = (line for line in (DATA / name).read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    return list(csv.DictReader(lines))


def pairs(text):
    """`a = b, c` as [(a, b), (c, c)]."""
    parts = [part.split(" = ", 1) for part in text.split(", ")]
    return [(part[0].strip(), part[-1].strip()) for part in parts]


def counted(rows, row_name, column_name):
    names = list(dict.fromkeys(row[row_name] for row in rows))
    columns = list(dict.fromkeys(row[column_name] for row in rows))
    yield [row_name.replace("_", " "), *columns]
    for name in names:
        yield [name, *(sum(row[row_name] == name and row[column_name] == column for row in rows) for column in columns)]


def chosen(rows, columns):
    yield [heading for _, heading in columns]
    for row in rows:
        yield [row[name] for name, _ in columns]


def table(options):
    name, *rest = [part.strip() for part in options.split(";")]
    given = dict(part.split(": ", 1) for part in rest)
    rows = read(name)
    for column, value in pairs(given["where"]) if "where" in given else []:
        rows = [row for row in rows if row[column] == value]
    if "count" in given:
        head, *body = counted(rows, *given["count"].split(" by "))
    else:
        columns = pairs(given["columns"]) if "columns" in given else [(column, column.replace("_", " ")) for column in rows[0]]
        head, *body = chosen(rows, columns)
    if not 0 < len(body) <= MOST_ROWS:
        sys.exit(f"{name}: {len(body)} rows, 1 to {MOST_ROWS} are allowed: {options}")
    lines = [head, ["---"] * len(head), *body]
    return "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)


def main():
    check = sys.argv[1:] == ["--check"]
    differing = []
    for page in sorted(DOCS.rglob("*.md")):
        old = page.read_text(encoding="utf-8")
        new = BLOCK.sub(lambda found: found[1] + table(found["options"]) + found[4], old)
        if old.count("<!-- table: ") != len(BLOCK.findall(old)):
            sys.exit(f"{page}: a table without its end")
        if new != old:
            differing.append(page.relative_to(DOCS))
            if not check:
                page.write_text(new, encoding="utf-8")
    for page in differing:
        print(f"{page}: {'differs from its data' if check else 'rewritten'}")
    return 1 if check and differing else 0


if __name__ == "__main__":
    sys.exit(main())
