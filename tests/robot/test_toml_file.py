"""TOML that is made to take long is refused before it is read."""

from __future__ import annotations

from time import process_time

import pytest

from robot.settings import SettingError
from robot.toml_file import DEEPEST, parse_toml

LONG_KEYS = {
    "of a value": lambda n: ".".join("a" * n) + " = 1",
    "of a table": lambda n: f"x = 1\n[{'.'.join('a' * n)}]",
    "of tables in a list": lambda n: f"[[{' . '.join('a' * n)}]]",
    "within a table of one line": lambda n: f"x = {{ y = 1, {'.'.join('a' * n)} = 1 }}",
    "with quotes": lambda n: ".".join(['"a b"'] * n) + " = 1",
    "with escaped quotes": lambda n: ".".join(['"a\\"b"'] * n) + " = 1",
    "with single quotes": lambda n: "\t." + ".".join(["'a'"] * n) + " = 1",
}


@pytest.mark.parametrize("kind", LONG_KEYS)
def test_a_key_of_very_many_parts_is_refused_at_once(kind: str) -> None:
    begin = process_time()
    with pytest.raises(SettingError, match=r"no TOML|more than 20 parts in line [12]; valid are"):
        parse_toml(LONG_KEYS[kind](80_000), "robot.toml")
    assert process_time() - begin < 0.5


def test_keys_of_a_few_parts_and_dots_in_values_are_taken() -> None:
    key = ".".join("abcdefghijklmnopqrst")
    dots = ".".join("x" * 100)
    text = f"{key} = \"{dots}\"\nlist = [{'1.5, ' * 100}]\n# {dots}\n'{dots}' = 1\n"
    found = parse_toml(text, "robot.toml")
    assert found[dots] == 1
    assert len(found["list"]) == 100
    for part in key.split("."):
        found = found[part]
    assert found == dots
    assert len(key.split(".")) == DEEPEST


@pytest.mark.parametrize(
    "part", ["a", " ", "a.", '"', '"\\', "'", "[", "{", ",", "a . ", "[a.", "\\"]
)
def test_the_look_at_the_keys_takes_linear_time(part: str) -> None:
    begin = process_time()
    with pytest.raises(SettingError):
        parse_toml(part * (900_000 // len(part)) + "?", "robot.toml")
    assert process_time() - begin < 3
