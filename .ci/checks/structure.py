#!/usr/bin/env python3
"""The structure of the code: no circle of files, no import upwards, a small core; and the figures that describe it.

    structure.py                  check this tree and print its figures
    structure.py --write-known    write the circles and upward imports of this tree to structure-known.txt
    structure.py --list           also print every circle with the imports that close it
    structure.py --figures        print the figures only
    structure.py --root DIR       the figures of another tree, also of one in which the core is no crate of its own

An edge is a `use` line or a qualified path (`crate::…`, `super::…`, `raceway_core::…`, or one that begins with a name in
scope). A name that a module re-exports counts for the file that defines it. A `pub use` of a name that the file itself does
not mention is a listing and no edge. Test code is left out: items under `#[cfg(test)]` and files named tests.
"""

import argparse
import bisect
import json
import pathlib
import re
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
KNOWN = HERE / "structure-known.txt"

# From the top down: no room imports one that stands before it.
ORDER = [
    "main", "commands", "config", "api", "jobs", "article", "render", "plots", "contract",
    "study", "sampling", "machine", "rotor", "orders", "measured", "simulation", "physics", "numerics",
]
# The same inside `simulation`; `result` stands beside `error`.
ACTS = [["work_precision"], ["solve"], ["error", "result"], ["model"], ["recording"], ["input"]]

FORBIDDEN = {"serde", "serde_json", "tokio", "axum", "sqlx", "utoipa", "hyper"}
# A package that has one of these as a build dependency compiles C or links a library of the system.
C_BUILD = {"cc", "cmake", "pkg-config", "bindgen", "vcpkg"}
MOST_CRATES = 45
LONG_FILE = 500

TOKEN = re.compile(
    r"""(?P<line>//[^\n]*)|(?P<block>/\*)|(?P<raw>\bb?r(?P<hashes>\#*)")|(?P<string>b?"(?:\\.|[^"\\])*")"""
    r"""|(?P<char>b?'(?:\\(?:x[0-9a-fA-F]{2}|u\{[^}]*\}|.)|[^\\'\n])')""",
    re.DOTALL,
)
NOT_NEWLINE = re.compile(r"[^\n]")
TEST_ITEM = re.compile(r"#\[cfg\((?:test|all\((?:[^()\]]*,\s*)?test\b[^\]]*)\)\]")
MODULE_FILE = re.compile(r"\bmod\s+(\w+)\s*;")
INLINE_MODULE = re.compile(r"\bmod\s+(\w+)\s*\{")
USE = re.compile(r"(?P<visibility>\bpub(?:\s*\([^)]*\))?\s+)?\buse\s+(?P<tree>[^;]+);")
PATH = re.compile(r"(?<![\w:])([A-Za-z_]\w*(?:\s*::\s*[A-Za-z_]\w*)+)")
ITEM = re.compile(r"\b(?:fn|struct|enum|trait|const|static|type|union|macro_rules!)\s+(?:mut\s+)?([A-Za-z_]\w*)")
CONSTANT = re.compile(r"\b(?:const|static)\s+(?:mut\s+)?[A-Z][A-Z0-9_]*\s*:")
PUBLIC = re.compile(
    r"\bpub\s+(?:(?:const|unsafe|async)\s+)*(?:fn|struct|enum|trait|const|static|type|union|mod)\s+\w"
)


def blanked(text, kept=" "):
    return NOT_NEWLINE.sub(kept, text)


def masked(text):
    """The text with comments as spaces and with the contents of strings as `\\1`, each character in its place."""
    parts, position = [], 0
    while match := TOKEN.search(text, position):
        parts.append(text[position:match.start()])
        end = match.end()
        if match.group("line"):
            parts.append(blanked(match.group()))
        elif match.group("block"):
            depth = 1
            for mark in re.finditer(r"/\*|\*/", text[end:]):
                depth += 1 if mark.group() == "/*" else -1
                if depth == 0:
                    end += mark.end()
                    break
            parts.append(blanked(text[match.start():end]))
        else:
            if match.group("raw"):
                close = '"' + match.group("hashes")
                end = text.index(close, end) + len(close)
            parts.append(blanked(text[match.start():end], "\1"))
        position = end
    parts.append(text[position:])
    return "".join(parts)


def closing(text, start):
    """Where the bracket that opens at `start` closes."""
    depth = 0
    for position in range(start, len(text)):
        if text[position] in "{[(":
            depth += 1
        elif text[position] in "}])":
            depth -= 1
            if depth == 0:
                return position
    raise ValueError("a bracket that never closes")


def item_end(text, position):
    """The end of the item that begins at `position`, behind its attributes."""
    while attribute := re.match(r"\s*#\[", text[position:]):
        position = closing(text, position + attribute.end() - 1) + 1
    head = re.match(r"\s*(pub(?:\s*\([^)]*\))?\s+)?(\w+)", text[position:])
    keyword = head.group(2) if head else ""
    is_item = keyword in {"use", "mod", "fn", "struct", "enum", "impl", "trait", "const", "static", "type", "unsafe", "async", "let"}
    while position < len(text):
        character = text[position]
        if character in "([":
            position = closing(text, position)
        elif character == "{":
            position = closing(text, position)
            if keyword not in {"use", "const", "static", "let", "type"}:
                return position + 1
        elif character == ";" or (character == "," and not is_item):
            return position + 1
        elif character == "}":
            return position
        position += 1
    return position


class File:
    """One file without its test code."""

    def __init__(self, path, name):
        self.path, self.name = path, name
        self.lines = 0
        self.test_modules = []
        text = path.read_text(encoding="utf-8")
        self.lines = text.count("\n")
        text = masked(text)
        if re.search(r"#!\[cfg\(test\)\]", text):
            text = blanked(text)
        while match := TEST_ITEM.search(text):
            end = item_end(text, match.end())
            item = text[match.start():end]
            if module := MODULE_FILE.search(item):
                self.test_modules.append(module.group(1))
            text = text[:match.start()] + blanked(item) + text[end:]
        self.text = text
        self.code_lines = sum(1 for line in text.splitlines() if line.strip())


def leaves(tree, prefix=()):
    """The paths of a use tree, each with the name it is known by (`*`: all)."""
    tree = tree.strip()
    head = re.match(r"(?:::)?\s*((?:\w+\s*::\s*)*)", tree)
    segments = prefix + tuple(re.findall(r"\w+", head.group(1)))
    rest = tree[head.end():].strip()
    if rest.startswith("{"):
        inner, depth, start = rest[1:closing(rest, 0)], 0, 0
        for position, character in enumerate(inner + ","):
            if character == "{":
                depth += 1
            elif character == "}":
                depth -= 1
            elif character == "," and depth == 0:
                if inner[start:position].strip():
                    yield from leaves(inner[start:position], segments)
                start = position + 1
        return
    if rest == "*":
        yield segments, "*"
        return
    named = re.match(r"(\w+)(?:\s+as\s+(\w+))?$", rest)
    if not named:
        return
    if named.group(1) == "self":
        yield segments, named.group(2) or segments[-1]
    else:
        yield segments + (named.group(1),), named.group(2) or named.group(1)


class Module:
    """What is known by name in one module. Modules in one file share it."""

    def __init__(self, file):
        self.file = file
        self.names, self.globs, self.items, self.children = {}, [], set(), set()


class Tree:
    """The files of both packages, their modules, and which file mentions which."""

    def __init__(self, root):
        self.root = pathlib.Path(root).resolve()
        self.files, self.modules, self.spans = [], {}, {}
        core = self.root / "crates" / "raceway-core" / "src"
        self.has_core = core.is_dir()
        if self.has_core:
            self.read("raceway_core", core)
        self.read("raceway", self.root / "src")
        self.scan()
        self.edges = {}
        for file in self.files:
            self.follow(file)

    def read(self, crate, folder):
        excluded, found = set(), []
        for path in sorted(folder.rglob("*.rs")):
            parts = path.relative_to(folder).with_suffix("").parts
            if "tests" in parts:
                continue
            is_root = parts in {("lib",), ("main",)}
            module = () if is_root else parts[:-1] if parts[-1] == "mod" else parts
            file = File(path, str(path.relative_to(self.root)))
            file.crate, file.module, file.is_main = crate, module, parts == ("main",)
            file.is_listing = parts[-1] in {"lib", "mod"}
            found.append(file)
            excluded |= {module + (name,) for name in file.test_modules}
        for file in found:
            if any(file.module[:length] in excluded for length in range(1, len(file.module) + 1)):
                continue
            self.files.append(file)
            key = ("main" if file.is_main else crate, file.module)
            file.key = key
            self.modules[key] = Module(file)

    def scan(self):
        for file in self.files:
            spans = [(0, len(file.text), file.key)]
            for match in INLINE_MODULE.finditer(file.text):
                outer = next(key for start, end, key in reversed(spans) if start <= match.start() < end)
                key = (outer[0], outer[1] + (match.group(1),))
                spans.append((match.start(), closing(file.text, match.end() - 1), key))
                self.modules[key] = Module(file)
            self.spans[file.name] = spans
        for crate, path in list(self.modules):
            if path:
                parent = self.modules.get((crate, path[:-1]))
                if parent:
                    parent.children.add(path[-1])
        for file in self.files:
            file.uses = []
            for match in USE.finditer(file.text):
                module = self.modules[self.at(file, match.start())]
                for path, name in leaves(match.group("tree")):
                    file.uses.append((match.start(), path, name, bool(match.group("visibility"))))
                    if name == "*":
                        module.globs.append(path)
                    elif name != "_":
                        module.names[name] = path
            file.body = USE.sub(lambda match: blanked(match.group()), file.text)
            for match in ITEM.finditer(file.body):
                self.modules[self.at(file, match.start())].items.add(match.group(1))
            file.words = set(re.findall(r"\w+", file.body))

    def at(self, file, position):
        return next(key for start, end, key in reversed(self.spans[file.name]) if start <= position <= end)

    def begin(self, key, path):
        """The module that a path is looked up from, and what is left of the path; None: another crate's."""
        crate, module = key
        first = path[0]
        if first == "crate":
            return (crate, ()), path[1:]
        if first in {"raceway_core", "raceway"} and (first, ()) in self.modules:
            return (first, ()), path[1:]
        if first == "self":
            return key, path[1:]
        if first == "super":
            while path and path[0] == "super":
                module, path = module[:-1], path[1:]
            return (crate, module), path
        here = self.modules.get(key)
        if here and (first in here.children or (first in here.names and here.names[first] != path)):
            return key, path
        return None, path

    def resolve(self, key, path, seen=frozenset()):
        """The module or the file that a path names: ("module", key), ("file", File) or None."""
        if (key, path) in seen or not path:
            return None
        seen = seen | {(key, path)}
        start, rest = self.begin(key, path)
        return self.descend(start, rest, seen) if start else None

    def descend(self, key, rest, seen):
        while rest:
            module = self.modules.get(key)
            if module is None:
                return None
            name, rest = rest[0], rest[1:]
            if name in module.children:
                key = (key[0], key[1] + (name,))
                continue
            if name in module.names:
                found = self.resolve(key, module.names[name], seen)
            elif name in module.items:
                found = ("file", module.file)
            else:
                found = None
                for path in module.globs:
                    place = self.resolve(key, path, seen)
                    if place and place[0] == "module" and (place[1], name) not in seen:
                        found = self.lookup(place[1], name, seen | {(place[1], name)})
                    if found:
                        break
                found = found or ("file", module.file)
            if found is None or found[0] == "file":
                return found
            key = found[1]
        return ("module", key) if key in self.modules else None

    def lookup(self, key, name, seen):
        module = self.modules[key]
        if name in module.children or name in module.names or name in module.items or module.globs:
            found = self.descend(key, (name,), seen)
            if name in module.children or name in module.names or name in module.items or (
                    found and found != ("file", module.file)):
                return found
        return None

    def follow(self, file):
        targets = {}

        def add(found, position):
            if found is None:
                return
            if found[0] == "module":
                module = self.modules[found[1]]
                # A folder is a place for names; the paths that begin with it tell which file is meant.
                if module.children or module.file.is_listing:
                    return
                target = module.file
            else:
                target = found[1]
            if target is not file:
                targets.setdefault(target.name, position)

        for position, path, name, is_public in file.uses:
            if is_public and (name == "*" or name not in file.words):
                continue
            add(self.resolve(self.at(file, position), path), position)
        for match in PATH.finditer(file.body):
            path = tuple(re.findall(r"\w+", match.group(1)))
            add(self.resolve(self.at(file, match.start()), path), match.start())
        starts = [mark.start() for mark in re.finditer("\n", file.text)]
        self.edges[file.name] = {name: bisect.bisect_left(starts, position) + 1 for name, position in targets.items()}


def circles(edges):
    """The sets of files that reach each other (Tarjan), largest first."""
    index, low, on_stack, stack, found = {}, {}, set(), [], []

    def visit(node):
        index[node] = low[node] = len(index)
        stack.append(node)
        on_stack.add(node)
        for target in sorted(edges.get(node, ())):
            if target not in index:
                visit(target)
                low[node] = min(low[node], low[target])
            elif target in on_stack:
                low[node] = min(low[node], index[target])
        if low[node] == index[node]:
            members = []
            while True:
                member = stack.pop()
                on_stack.discard(member)
                members.append(member)
                if member == node:
                    break
            if len(members) > 1:
                found.append(sorted(members))

    sys.setrecursionlimit(10_000)
    for node in sorted(edges):
        if node not in index:
            visit(node)
    return sorted(found, key=len, reverse=True)


def room(file):
    """The room of a file; None for a crate's list of its modules."""
    if file.is_main:
        return "main"
    return file.module[0] if file.module else None


def act(file):
    """The folder of a file inside `simulation`; None for files beside those folders."""
    if room(file) != "simulation" or len(file.module) < 2:
        return None
    if len(file.module) == 2 and not file.is_listing and not file.has_folder:
        return None
    return file.module[1]


def upward(tree):
    """Each import of a room, or of an act of the simulation, from below it."""
    files = {file.name: file for file in tree.files}
    for file in tree.files:
        file.has_folder = file.path.with_suffix("").is_dir()
    rank = {name: place for place, name in enumerate(ORDER)}
    acts = {name: place for place, names in enumerate(ACTS) for name in names}
    for name, targets in tree.edges.items():
        for target in targets:
            upper, lower = room(files[name]), room(files[target])
            if upper is None or lower is None:
                # A crate's root only lists its rooms; what they share stands in one of them.
                if lower is None and upper is not None:
                    yield name, target
            elif rank[lower] < rank[upper]:
                yield name, target
            elif upper == lower == "simulation":
                upper, lower = act(files[name]), act(files[target])
                if upper in acts and lower in acts and acts[lower] < acts[upper]:
                    yield name, target


def figures(tree):
    in_core = {"machine", "measured", "numerics", "orders", "physics", "rotor", "sampling", "simulation", "study"}
    core = [file for file in tree.files if (file.crate == "raceway_core" if tree.has_core else room(file) in in_core)]
    simulation = [file for file in core if room(file) == "simulation"]
    lines = sum(file.code_lines for file in tree.files)
    core_lines = sum(file.code_lines for file in core)
    of_simulation = sum(file.code_lines for file in simulation)
    constants = sum(len(CONSTANT.findall(file.body)) for file in simulation)
    public = sum(len(PUBLIC.findall(file.body)) for file in core)
    long = sorted((file for file in tree.files if file.lines > LONG_FILE), key=lambda file: -file.lines)
    print("counting rule: a line of code is one that is not blank and not only a comment; tests are left out")
    print("  (items under #[cfg(test)], files named tests). A constant: `const NAME:` or `static NAME:`. A public item:")
    print("  `pub` (not `pub(…)`) fn, struct, enum, trait, const, static, type or mod; fields, variants and re-exports are none.")
    print(f"files: {len(tree.files)}, lines of code: {lines}; core: {len(core)} files, {core_lines} lines")
    print(f"named constants in simulation: {constants} in {of_simulation} lines, {1000 * constants / of_simulation:.1f} per 1000")
    print(f"public items in the core: {public} in {core_lines} lines, {1000 * public / core_lines:.1f} per 1000")
    print(f"files over {LONG_FILE} lines (all lines, tests beside the code included): {len(long)}")
    for file in long:
        print(f"  {file.lines:5d}  {file.name}")
    found = circles(tree.edges)
    pairs = sum(1 for name, targets in tree.edges.items() for target in targets if name < target and name in tree.edges[target])
    print(f"circles: {len(found)} with {sum(map(len, found))} files (the largest {max(map(len, found), default=0)});"
          f" pairs of files that import each other: {pairs}")
    return found


def dependencies():
    """What is wrong with the dependencies of the core."""
    def cargo(*arguments):
        return subprocess.run(["cargo", *arguments], cwd=ROOT, capture_output=True, text=True, check=True).stdout

    listed = cargo("tree", "--locked", "-p", "raceway-core", "-e", "normal", "--prefix", "none", "-f", "{p}")
    packages = {tuple(line.split()[:2]) for line in listed.splitlines() if line.strip()}
    print(f"crates in the core's tree, itself included: {len(packages)} (at most {MOST_CRATES})")
    if len(packages) > MOST_CRATES:
        yield f"raceway-core depends on {len(packages)} crates, more than {MOST_CRATES}"
    metadata = json.loads(cargo("metadata", "--locked", "--format-version", "1"))
    for package in metadata["packages"]:
        if (package["name"], "v" + package["version"]) not in packages:
            continue
        name = package["name"]
        if name in FORBIDDEN:
            yield f"raceway-core must not depend on {name}"
        if package["links"]:
            yield f"raceway-core must not depend on {name}, which links {package['links']}"
        built = {entry["name"] for entry in package["dependencies"] if entry["kind"] == "build" and not entry["optional"]}
        for tool in sorted(built & C_BUILD):
            yield f"raceway-core must not depend on {name}, which is built with {tool}"


SCHEMA = re.compile(r"derive\([^)]*ToSchema[^)]*\)\]\s*((?:#\[(?:[^\[\]]|\[[^\]]*\])*\]\s*)*)(?:pub(?:\([^)]*\))?\s+)?(?:struct|enum)\s+(\w+)")
RENAMED = re.compile(r"schema\(as = (\w+)\)")


def schemas_of_one_name():
    """Types whose schemas have one name: the document would describe only one of them."""
    places = {}
    for file in sorted((ROOT / "src").rglob("*.rs")):
        for attributes, name in SCHEMA.findall(file.read_text(encoding="utf-8")):
            renamed = RENAMED.search(attributes)
            places.setdefault(renamed.group(1) if renamed else name, []).append(file.relative_to(ROOT))
    for name, files in places.items():
        if len(files) > 1:
            yield f"the schema {name} has {len(files)} types: {', '.join(map(str, files))}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", metavar="DIR")
    parser.add_argument("--write-known", action="store_true")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--figures", action="store_true")
    options = parser.parse_args()
    tree = Tree(options.root or ROOT)
    found = figures(tree)
    # Which circle each file is part of.
    part = {name: place for place, members in enumerate(found) for name in members}
    closed = {(name, target): f"circle: {name} -> {target}" for name, targets in tree.edges.items() for target in targets
              if name in part and part.get(target) == part[name]}
    if options.list:
        for members in found:
            print(f"\ncircle of {len(members)} files:")
            for name in members:
                inside = {target: line for target, line in tree.edges[name].items() if part.get(target) == part[name]}
                for target, line in sorted(inside.items()):
                    print(f"  {name}:{line} -> {target}{'  (both ways)' if name in tree.edges[target] else ''}")
    if options.figures or options.root:
        return 0
    unknown = sorted({room(file) for file in tree.files} - set(ORDER) - {None})
    rising = {edge: f"upwards: {edge[0]} -> {edge[1]}" for edge in upward(tree)} if not unknown else {}
    print(f"imports upwards: {len(rising)}")
    faults = {}
    for kind in (closed, rising):
        for (name, target), text in kind.items():
            faults[text] = f"{name}:{tree.edges[name][target]}"
    if options.write_known:
        head = "# Imports that are part of a circle of files, or that point upwards. This list may only shrink;\n" \
               "# .ci/checks/structure.py --write-known writes it anew.\n"
        KNOWN.write_text(head + "".join(f"{text}\n" for text in sorted(faults)), encoding="utf-8")
        print(f"{KNOWN.name}: {len(faults)} lines")
        return 0
    known = {line for line in KNOWN.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")}
    wrong = [f"the room {name} has no place in the order; name it in ORDER" for name in unknown]
    wrong += [f"{text} (at {faults[text]}): new; move what both files share into a third file below both"
              for text in sorted(set(faults) - known)]
    wrong += [f"{text}: no longer there; remove the line from {KNOWN.name}" for text in sorted(known - set(faults))]
    wrong += dependencies()
    wrong += schemas_of_one_name()
    for fault in wrong:
        print(f"FAILED: {fault}", file=sys.stderr)
    if not wrong:
        print(f"structure: as it should be, but for {len(known)} known imports" if known else "structure: as it should be")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
