"""TypeScript types of the wire messages, written from their JSON schema.

``python -m app.tools.typescript`` writes ``frontend/messages.d.ts``; with ``--check`` it fails
when that file is stale. The page needs no build step: editors read the file through JSDoc.
"""

from __future__ import annotations

import argparse
import json
import sys
import textwrap
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from app.engine.plugging import plugged
from app.messages.schema import schema
from robot.errors import BrickPoseError

TARGET = Path(__file__).parents[2] / "frontend" / "messages.d.ts"
HEADER = "// Made from the program's classes of messages by `python -m app.tools.typescript`.\n"
PRIMITIVES = {
    "string": "string",
    "number": "number",
    "integer": "number",
    "boolean": "boolean",
    "null": "null",
}


class SchemaError(BrickPoseError, ValueError):
    """The schema has a form that this module cannot write as TypeScript."""


def type_of(node: Mapping[str, Any]) -> str:
    """Return the TypeScript type of one schema node, on one line.

    Raises:
        SchemaError: the form is unknown; the message names the node and the known forms.
    """
    if "$ref" in node:
        return str(node["$ref"]).rsplit("/", 1)[-1]
    if "const" in node:
        return json.dumps(node["const"])
    if "enum" in node:
        return " | ".join(json.dumps(value) for value in node["enum"])
    for key in ("anyOf", "oneOf"):
        if key in node:
            return " | ".join(dict.fromkeys(type_of(option) for option in node[key]))
    return _type_by_name(node)


def _type_by_name(node: Mapping[str, Any]) -> str:
    kind = node.get("type")
    if kind == "array":
        return _array(node)
    if kind == "object":
        values = node.get("additionalProperties")
        if isinstance(values, Mapping):
            return f"Record<string, {type_of(values)}>"
    if isinstance(kind, str) and kind in PRIMITIVES:
        return PRIMITIVES[kind]
    known = ", ".join(["$ref", "const", "enum", "anyOf", "oneOf", "array", "map", *PRIMITIVES])
    raise SchemaError(f"no TypeScript type for {dict(node)!r}; known are {known}")


def _array(node: Mapping[str, Any]) -> str:
    if "prefixItems" in node:
        return "[" + ", ".join(type_of(item) for item in node["prefixItems"]) + "]"
    item = type_of(node["items"])
    return f"({item})[]" if " | " in item else f"{item}[]"


def interface(name: str, node: Mapping[str, Any]) -> str:
    """Return a message as an exported interface with descriptions, or a list of words as a type.

    Keys with a default may be absent, except the constant ``type`` that tells messages apart.
    """
    if "enum" in node:
        return "\n".join(
            [*_comment(node.get("description"), ""), f"export type {name} = {type_of(node)};\n"]
        )
    required = set(node.get("required", ()))
    lines = [*_comment(node.get("description"), ""), f"export interface {name} {{"]
    for key, value in node["properties"].items():
        optional = "" if key in required or "const" in value else "?"
        lines += [
            *_comment(value.get("description"), "  "),
            f"  {key}{optional}: {type_of(value)};",
        ]
    return "\n".join([*lines, "}\n"])


def _comment(text: str | None, indent: str) -> list[str]:
    if not text:
        return []
    lines = textwrap.wrap(" ".join(text.split()), 96 - len(indent))
    if len(lines) == 1:
        return [f"{indent}/** {lines[0]} */"]
    return [f"{indent}/**", *(f"{indent} * {line}" for line in lines), f"{indent} */"]


def render(definitions: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the whole file; ``Command`` is the union of all messages named ``...Command``."""
    commands = [name for name in sorted(definitions) if name.endswith("Command")]
    union = "export type Command =\n" + "\n".join(f"  | {name}" for name in commands) + ";\n"
    interfaces = [interface(name, definitions[name]) for name in sorted(definitions)]
    return "\n".join([HEADER, union, *interfaces])


def main(arguments: list[str] | None = None) -> int:
    """Write the file, or with ``--check`` only compare it; return 1 when it is stale."""
    parser = argparse.ArgumentParser(prog="python -m app.tools.typescript", description=__doc__)
    parser.add_argument("--check", action="store_true", help="fail when the file is stale")
    parser.add_argument("--target", type=Path, default=TARGET, help="default: %(default)s")
    options = parser.parse_args(arguments)
    target: Path = options.target
    text = render(schema(plugged().all_messages))
    if not options.check:
        target.write_text(text, encoding="utf-8")
        return 0
    if target.is_file() and target.read_text(encoding="utf-8") == text:
        return 0
    sys.stderr.write(f"{target} is stale: run python -m app.tools.typescript\n")
    return 1


if __name__ == "__main__":
    sys.exit(main())
