"""Types of the API's JSON for Python, from the OpenAPI document: one TypedDict, alias or Literal for each schema."""

from __future__ import annotations

import json
from typing import Any

HEAD = '''"""Types of the JSON of the API. Made from openapi/openapi.json."""

from typing import Any, Literal, TypedDict, Union

'''


def module(document: dict[str, Any]) -> str:
    """Source of the module."""
    schemas = document["components"]["schemas"]
    return HEAD + "\n".join(_definition(name, schemas[name]) for name in sorted(schemas))


def _definition(name: str, schema: dict[str, Any]) -> str:
    # A field named `from` is no identifier, so that fields stand in the functional form.
    if "properties" not in schema:
        return f"{name} = {_expression(schema, quoted=True)}\n"
    required = set(schema.get("required", []))
    parts: dict[bool, list[str]] = {True: [], False: []}
    for field, inner in schema["properties"].items():
        parts[field in required].append(f"    {json.dumps(field)}: {json.dumps(_expression(inner))},\n")
    text, bases = "", []
    for is_required, suffix, option in ((True, "Required", ""), (False, "Optional", ", total=False")):
        if parts[is_required]:
            bases.append(f"_{name}{suffix}")
            text += f'{bases[-1]} = TypedDict("{bases[-1]}", {{\n{"".join(parts[is_required])}}}{option})\n'
    description = json.dumps(" ".join(schema.get("description", name).split()), ensure_ascii=False)
    return f"{text}class {name}({', '.join(bases) or 'TypedDict'}):\n    {description}\n"


def _expression(schema: Any, quoted: bool = False) -> str:
    """The type of a schema as an expression. In an alias, which Python evaluates, names of other schemas are quoted."""
    if not isinstance(schema, dict):
        return "Any"
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return json.dumps(name) if quoted else str(name)
    for several in ("oneOf", "anyOf"):
        if several in schema:
            return _union([_expression(one, quoted) for one in schema[several]])
    if "allOf" in schema:
        return _expression(schema["allOf"][0], quoted) if len(schema["allOf"]) == 1 else "Any"
    if "enum" in schema:
        return f"Literal[{', '.join(map(json.dumps, schema['enum']))}]"
    kinds = schema.get("type", [])
    return _union([_simple(kind, schema, quoted) for kind in ([kinds] if isinstance(kinds, str) else kinds)])


def _union(types: list[str]) -> str:
    return types[0] if len(types) == 1 else f"Union[{', '.join(types)}]" if types else "Any"


def _simple(kind: str, schema: dict[str, Any], quoted: bool) -> str:
    if kind == "array":
        return f"list[{_expression(schema.get('items'), quoted)}]"
    if kind == "object":
        return f"dict[str, {_expression(schema.get('additionalProperties'), quoted)}]"
    return {"string": "str", "number": "float", "integer": "int", "boolean": "bool", "null": "None"}[kind]
