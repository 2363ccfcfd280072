#!/usr/bin/env python3
"""Writes the reference pages from openapi/openapi.json.

    generate.py            parameters.md, results.md and, where the document has message codes, messages.md
    generate.py --check    writes nothing; status 1 where a page is not what the document says
"""

import json
import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
DOCUMENT = HERE.parents[1] / "openapi" / "openapi.json"
NOTICE = "<!-- Written by docs/reference/generate.py from openapi/openapi.json. Change the schema, not this page. -->\n"
KINDS = ("simulation", "study", "optimum", "uncertainty", "accuracy")

# Schemas of the answers that results.md lists, with the address of each.
ANSWERS = {
    "Metrics": "`GET /v1/jobs/{id}/metrics`, and `metrics` of a finished job",
    "UncertaintyAnswer": "`GET /v1/jobs/{id}/uncertainty`",
    "OrdersAnswer": "`GET /v1/jobs/{id}/orders`",
    "WaterfallAnswer": "`GET /v1/jobs/{id}/waterfall`",
    "MeasurementComparison": "`POST /v1/jobs/{id}/comparison`",
    "RotorAnswer": "`POST /v1/rotor`, and `GET /v1/jobs/{id}/rotor`",
    "MachinePlanAnswer": "`POST /v1/machine/resolve`",
    "MachineJobAnswer": "`GET /v1/jobs/{id}/machine`",
    "CatalogueAnswer": "`GET /v1/catalogue`",
}
# Parts that another page describes.
ELSEWHERE = {"MachineJob": "[machine job](parameters.md#machine-job)", "AccuracyAnswer": "[accuracy](accuracy.md#accuracy)", "SolverAnswer": "[solver](accuracy.md#solver)",
             "LeftOutAnswer": "[left out](accuracy.md#left_out)", "Message": "[messages](messages.md)",
             "MessageAnswer": "[messages](messages.md)"}


class Schemas:
    """The schemas of an OpenAPI document."""

    def __init__(self, document):
        self.all = document["components"]["schemas"]

    def target(self, schema):
        """Name and schema that a property refers to; the name is None for an inline schema."""
        parts = schema.get("allOf", [schema])
        for part in parts:
            if "$ref" in part:
                name = part["$ref"].rsplit("/", 1)[1]
                return name, self.all[name]
        return None, schema

    def objects(self, schema):
        """Names of the object schemas that a property holds, through choices, arrays and maps."""
        name, found = self.target(schema)
        if "properties" in found and name:
            return [name]
        inner = found.get("oneOf", []) + found.get("anyOf", [])
        inner += [found[key] for key in ("items", "additionalProperties") if isinstance(found.get(key), dict)]
        return [one for each in inner for one in self.objects(each)]

    def allowed(self, schema):
        """Type, range or choices of a property."""
        name, found = self.target(schema)
        choices = found.get("oneOf", []) + found.get("anyOf", [])
        if "enum" in found and len(found["enum"]) > 8:
            return [f"one of {len(found['enum'])} names"]
        if "enum" in found:
            return [code(value) for value in found["enum"]]
        if choices:
            return [text for choice in choices for text in self.allowed(choice)]
        if "properties" in found:
            return [f"[{title(name)}](#{anchor(name)})" if name else "{" + ", ".join(map(code, found["properties"])) + "}"]
        if found.get("type") == "array":
            items = self.allowed(found["items"])
            least, most = found.get("minItems"), found.get("maxItems")
            count = f"{least}–{number(most)} of " if least and most else f"up to {number(most)} of " if most else "list of "
            return [count + ", ".join(items)]
        bounds = limits(found)
        return [bounds or {"number": "number", "integer": "integer", "string": "text", "boolean": "`true`, `false`"}.get(found.get("type"), "")]


def limits(schema):
    low, high = schema.get("minimum"), schema.get("maximum")
    above, below = schema.get("exclusiveMinimum"), schema.get("exclusiveMaximum")
    if low is None and high is None and above is None and below is None:
        return ""
    if low is not None and low == -(high or 0):
        return f"±{number(high)}"
    start = f"({number(above)}" if above is not None else f"[{number(low)}" if low is not None else "(−∞"
    end = f"{number(below)})" if below is not None else f"{number(high)}]" if high is not None else "∞)"
    return f"{start}, {end}"


def number(value):
    """A number as it is read: 1e-6, 500 000, 0.02."""
    if value == 0:
        return "0"
    size = abs(value)
    if size >= 1e6 or size < 1e-3:
        mantissa, exponent = f"{value:e}".split("e")
        text = f"{mantissa.rstrip('0').rstrip('.')}e{int(exponent)}"
    elif size >= 1e4:
        text = f"{int(value):,}".replace(",", " ")
    else:
        text = f"{value:g}"
    return text.replace("-", "−", 1) if text.startswith("-") else text


def code(value):
    return f"`{value}`"


def anchor(name):
    return re.sub(r"[^a-z0-9 -]", "", title(name).lower()).replace(" ", "-")


def title(name):
    """A schema's name as a heading: LandInput is Land."""
    words = re.findall(r"[A-Z][a-z0-9]*", re.sub(r"(Input|Answer)$", "", name)) or [name]
    return " ".join([words[0], *(word.lower() for word in words[1:])])


def cell(text):
    return " ".join(text.split()).replace("|", "\\|")


def unit_of(text):
    found = re.search(r"\s*\[([^\]]{1,12})\]", text)
    return (found[1], text.replace(found[0], "", 1)) if found else ("", text)


def default_of(schema, text, required):
    """Default and the description without it: what the description says of it, else the schema's value."""
    found = re.search(r"\s*Default:? (.*?)\.(?=\s|$)", text, re.S)
    if found and len(found[1]) <= 200:
        return found[1], (text.replace(found[0], "", 1)).strip()
    if "default" in schema:
        value = schema["default"]
        if isinstance(value, list):
            return ", ".join(code(one) if isinstance(one, str) else number(one) for one in value) or "none", text
        if isinstance(value, bool) or isinstance(value, str):
            return code(str(value).lower() if isinstance(value, bool) else value), text
        return number(value), text
    return ("required" if required else ""), text


def table(schemas, schema, kinds=None):
    """Rows of an input object."""
    yield "| field | meaning | unit | default | allowed |\n|---|---|---|---|---|\n"
    for name, field in schema["properties"].items():
        of = kinds[name] if kinds else KINDS
        unit, text = unit_of(field.get("description", ""))
        required = name in schema.get("required", [])
        default, text = default_of(field, text, required)
        allowed = ", ".join(dict.fromkeys(one for one in schemas.allowed(field) if one))
        only = "" if tuple(of) == KINDS else f"{'/'.join(of)} only. "
        yield f"| `{name}` | {cell(only + text)} | {unit.replace('-', '') if unit == '-' else unit} | {cell(default)} | {cell(allowed)} |\n"


def parameters(schemas):
    yield "# Parameters\n\n" + NOTICE + """
Every field of a job. A field that is left out takes its default; `POST /v1/scenes/resolve` shows the values for a given scene.
Square brackets include the end of a range, round ones exclude it. Where to find a value and what a wrong one does:
[describe your bearing](../how-to/describe-your-bearing.md), [choice of the parameters](../explanation/parameters.md).

## Job

"""
    names = {"accuracy": "BearingAccuracyJob"}
    jobs = {kind: schemas.all[names.get(kind, kind.title() + "Job")] for kind in KINDS}
    merged, kinds = {}, {}
    for kind, job in jobs.items():
        for name, field in job["properties"].items():
            kinds.setdefault(name, []).append(kind)
            if name == "kind":
                field = {**field, "enum": list(KINDS)}
            merged.setdefault(name, field)
    for name in ("solver", "outputs"):
        kinds[name] = KINDS
    # `accuracy` has its own defaults of the times, which the description names.
    required = set.intersection(*(set(job.get("required", [])) for job in jobs.values()))
    required |= {name for name in merged if all(name in jobs[kind].get("required", []) for kind in kinds[name])}
    yield from table(schemas, {"properties": merged, "required": sorted(required)}, kinds)
    roots = [one for field in merged.values() for one in schemas.objects(field)]
    listed = order_of(schemas, roots)
    yield from objects(schemas, listed)
    # Jobs of shafts share materials and bearings with the others, and no other object.
    yield from objects(schemas, [name for name in order_of(schemas, ["RotorJob", "MachineJob", "ShaftAccuracyJob"]) if name not in listed])


def order_of(schemas, waiting):
    """Names of objects and of those inside them, each once and close to its use."""
    order = []
    while waiting:
        name = waiting.pop(0)
        if name not in order:
            order.append(name)
            inner = [one for field in schemas.all[name]["properties"].values() for one in schemas.objects(field)]
            waiting = inner + waiting
    return order


def objects(schemas, names):
    """A section for each object."""
    for name in names:
        schema = schemas.all[name]
        yield f"\n## {title(name)}\n\n{cell(schema.get('description', ''))}\n\n"
        fields = schema["properties"]
        choices = {tuple(schemas.allowed(field)) for field in fields.values()}
        if len(fields) > 3 and len(choices) == 1:
            yield f"Each field takes {', '.join(choices.pop())}.\n\n| field | meaning |\n|---|---|\n"
            for field, about in fields.items():
                yield f"| `{field}` | {cell(about.get('description', ''))} |\n"
        else:
            yield from table(schemas, schema)


def results(schemas):
    yield "# Results\n\n" + NOTICE + """
Fields of the metrics. A field that the request did not ask for, or that cannot be stated, is absent.
Table and best points of a study, and the answer of an optimum: [run a study or find an optimum](../how-to/run-a-study-or-find-an-optimum.md). The answer of an uncertainty job: [find the spread of a level](../how-to/find-the-spread-of-a-level.md). `GET /docs` has all answers with examples.
"""
    done = set(ELSEWHERE)
    for root, place in ANSWERS.items():
        if root not in schemas.all:
            continue
        waiting = [root]
        while waiting:
            name = waiting.pop(0)
            if name in done:
                continue
            done.add(name)
            schema = schemas.all[name]
            level, about = ("##", f"{place}. ") if name == root else ("###", "")
            yield f"\n{level} {title(name)}\n\n{about}{cell(schema.get('description', ''))}\n\n| field | meaning | unit |\n|---|---|---|\n"
            inner = []
            for field, of in schema["properties"].items():
                unit, text = unit_of(of.get("description", ""))
                objects = schemas.objects(of)
                links = ", ".join(ELSEWHERE.get(one, f"[{title(one)}](#{anchor(one)})") for one in objects)
                inner += objects
                yield f"| `{field}` | {cell(text)}{' ' + links if links else ''} | {'' if unit == '-' else unit} |\n"
            waiting = [one for one in inner if one not in done] + waiting


def messages(schemas):
    """The codes of messages, or nothing where the document has none.

    A code's text is the description of its variant, an entry of `x-enum-descriptions`, or a line "`code`: text" of the enum's description.
    """
    codes = []
    for name in ("MessageCode", "Message", "MessageAnswer"):
        schema = schemas.all.get(name, {})
        for variant in schema.get("oneOf", []):
            _, variant = schemas.target(variant)
            of = variant.get("properties", {}).get("code", variant)
            for value in of.get("enum", [of["const"]] if "const" in of else []):
                codes.append((value, variant.get("description", of.get("description", ""))))
        if not codes and "enum" in schema:
            lines = dict(re.findall(r"^[-* ]*`([a-z0-9_-]+)`: (.*(?:\n(?![-* ]*`).+)*)", schema.get("description", ""), re.M))
            about = schema.get("x-enum-descriptions") or [lines.get(value, "") for value in schema["enum"]]
            codes = list(zip(schema["enum"], about))
        if codes:
            break
    if not codes:
        return
    yield "# Messages\n\n" + NOTICE + """
Results and `POST /v1/scenes/resolve` carry `messages`. Branch on `code`; show `text` to the user.

| code | cause and remedy |
|---|---|
"""
    for value, about in codes:
        yield f"| `{value}` | {cell(about)} |\n"


def main():
    schemas = Schemas(json.loads(DOCUMENT.read_text(encoding="utf-8")))
    stale = []
    for page in (parameters, results, messages):
        text, path = "".join(page(schemas)), HERE / f"{page.__name__}.md"
        if "--check" in sys.argv[1:]:
            if (path.read_text(encoding="utf-8") if path.exists() else "") != text:
                stale.append(path.name)
        elif text:
            path.write_text(text, encoding="utf-8")
        else:
            path.unlink(missing_ok=True)
    if stale:
        sys.exit(f"not what openapi/openapi.json says: {', '.join(stale)}; run docs/reference/generate.py")


if __name__ == "__main__":
    main()
