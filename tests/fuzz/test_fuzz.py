"""Whatever bytes come, parsers take them or refuse them in a line; ``make fuzz`` asks longer."""

from pathlib import Path

import examination
import pytest
from examination import OverdueError, examine
from hypothesis import HealthCheck, given, settings
from parsers import program
from targets import CORPUS, TARGETS, VALID, kept_files, samples

KEPT = [(name, path) for name in TARGETS for path in kept_files(name)]
EXAMPLES = 40


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    program()  # takes longer than any input may
    return tmp_path_factory.mktemp("fuzz")


@pytest.mark.parametrize(("name", "path"), KEPT, ids=lambda item: getattr(item, "name", item))
def test_a_kept_file_is_taken_if_its_name_says_so_and_else_refused(name, path, folder):
    words = examine(TARGETS[name].parser, path.read_bytes(), folder)
    assert (words is None) == path.name.startswith(VALID), words


def test_each_target_keeps_files_of_both_kinds():
    assert {folder.name for folder in CORPUS.iterdir()} == set(TARGETS)
    for name in TARGETS:
        kinds = {path.name.startswith(VALID) for path in kept_files(name)}
        assert kinds == {True, False}, name


@pytest.mark.slow
@pytest.mark.parametrize("name", TARGETS)
def test_any_bytes_are_taken_or_refused_in_a_line(name, folder):
    target = TARGETS[name]

    @settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))
    @given(target.inputs(*samples(name)))
    def ask(data: bytes) -> None:
        examine(target.parser, data, folder)

    ask()


def endless(data: bytes, folder: Path) -> None:
    while True:
        pass


@pytest.mark.parametrize(
    ("parser", "defect", "words"),
    [
        (lambda data, folder: "two\nlines", AssertionError, "no line of text"),
        (lambda data, folder: "x" * 10_000, AssertionError, "10000 characters"),
        (lambda data, folder: bytearray(3 << 30), MemoryError, None),
        (lambda data, folder: data.decode(), UnicodeDecodeError, None),
        (endless, OverdueError, "of the processor"),
    ],
)
def test_a_defect_is_noticed(parser, defect, words, folder, monkeypatch):
    monkeypatch.setattr(examination, "PROCESSOR_S", 0.1)
    with pytest.raises(defect, match=words):
        examine(parser, b"\xff", folder)
