"""YAML of others: read as text, and never for long."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from robot.yaml_file import DEEPEST, parse_yaml


def test_values_stay_text() -> None:
    assert parse_yaml("a: 1\nb: [2, {c: true}]\n") == {"a": "1", "b": ["2", {"c": "true"}]}
    assert parse_yaml(b"\xef\xbb\xbfa: \xc3\xa4\n") == {"a": "ä"}


def test_lists_in_each_other_are_read_up_to_the_limit() -> None:
    content = parse_yaml("[" * DEEPEST + "]" * DEEPEST)
    for _ in range(DEEPEST - 1):
        (content,) = content
    assert content == []
    with pytest.raises(yaml.YAMLError, match=f"nested too deeply; valid are up to {DEEPEST}"):
        parse_yaml("[" * (DEEPEST + 1) + "]" * (DEEPEST + 1))


@given(st.sampled_from(["[", "{", "[{", "a: {"]), st.integers(DEEPEST + 1, 20_000))
def test_however_many_are_open_it_is_refused_without_being_read(opening: str, count: int) -> None:
    with pytest.raises(yaml.YAMLError, match="nested too deeply"):
        parse_yaml(opening * count)


def test_brackets_that_are_closed_do_not_count() -> None:
    assert len(parse_yaml("".join(f"- [{i}, {{x: {i}}}]\n" for i in range(1000)))) == 1000
    assert parse_yaml("a: 'x]]]]'\nb: [1]\n")["b"] == ["1"]
