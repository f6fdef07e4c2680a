"""The page's types follow the wire messages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine.plugging import plugged
from app.messages.schema import schema
from app.tools.typescript import (
    PRIMITIVES,
    TARGET,
    SchemaError,
    interface,
    main,
    render,
    type_of,
)


def test_the_types_in_the_repository_are_current() -> None:
    assert main(["--check"]) == 0, "run python -m app.tools.typescript"


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        ({"$ref": "#/$defs/PoseMessage"}, "PoseMessage"),
        ({"const": "stop", "type": "string"}, '"stop"'),
        ({"enum": ["idle", "drive"], "type": "string"}, '"idle" | "drive"'),
        ({"anyOf": [{"type": "number"}, {"type": "null"}]}, "number | null"),
        ({"anyOf": [{"type": "integer"}, {"type": "number"}]}, "number"),
        ({"type": "array", "items": {"type": "number"}}, "number[]"),
        (
            {"type": "array", "items": {"anyOf": [{"type": "number"}, {"type": "null"}]}},
            "(number | null)[]",
        ),
        (
            {"type": "array", "prefixItems": [{"type": "number"}, {"type": "string"}]},
            "[number, string]",
        ),
        (
            {"type": "object", "additionalProperties": {"type": "boolean"}},
            "Record<string, boolean>",
        ),
    ],
)
def test_each_form_of_schema_has_its_type(node: dict[str, Any], expected: str) -> None:
    assert type_of(node) == expected


@pytest.mark.parametrize("node", [{}, {"type": "object"}, {"type": "date"}, {"type": ["number"]}])
def test_an_unknown_form_is_refused_with_those_that_are_known(node: dict[str, Any]) -> None:
    with pytest.raises(SchemaError, match=r"known are .*anyOf"):
        type_of(node)


LEAVES = st.sampled_from([{"type": name} for name in PRIMITIVES])
NODES = st.recursive(
    LEAVES,
    lambda inner: (
        inner.map(lambda item: {"type": "array", "items": item})
        | st.lists(inner, min_size=1, max_size=3).map(lambda items: {"anyOf": items})
    ),
    max_leaves=12,
)


@given(NODES)
def test_an_array_of_a_union_keeps_the_union_together(node: dict[str, Any]) -> None:
    element = type_of(node)
    expected = f"({element})[]" if " | " in element else f"{element}[]"
    assert type_of({"type": "array", "items": node}) == expected
    assert expected.count("(") == expected.count(")")


def test_a_key_with_a_default_may_be_absent_but_never_the_type() -> None:
    node = {
        "description": "Stand still.",
        "properties": {
            "type": {"const": "stop", "default": "stop"},
            "id": {"type": "string", "default": None, "description": "Repeated."},
            "v": {"type": "number"},
        },
        "required": ["v"],
    }
    assert interface("StopCommand", node) == (
        "/** Stand still. */\n"
        "export interface StopCommand {\n"
        '  type: "stop";\n'
        "  /** Repeated. */\n"
        "  id?: string;\n"
        "  v: number;\n"
        "}\n"
    )


def test_every_message_and_the_union_of_commands_are_exported() -> None:
    definitions = schema(plugged().all_messages)
    text = render(definitions)
    for name in definitions:
        assert f"export interface {name} {{" in text or f"export type {name} = " in text
        assert (f"  | {name}" in text) == name.endswith("Command")


@pytest.mark.slow
def test_a_stale_or_absent_file_fails_the_check_and_writing_cures_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "messages.d.ts"
    assert main(["--check", "--target", str(target)]) == 1
    assert "is stale" in capsys.readouterr().err
    assert main(["--target", str(target)]) == 0
    assert main(["--check", "--target", str(target)]) == 0
    target.write_text(target.read_text() + "\n")
    assert main(["--check", "--target", str(target)]) == 1


def test_the_target_lies_beside_the_page() -> None:
    assert (TARGET.parent / "index.html").is_file()


def test_a_list_of_words_is_a_type_of_its_own() -> None:
    words = interface("State", {"enum": ["certain", "lost"], "description": "How sure."})
    assert words == '/** How sure. */\nexport type State = "certain" | "lost";\n'
