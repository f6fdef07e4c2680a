"""What ``make check`` says of modules: first sentences, constants, numbers, classes of one name."""

from __future__ import annotations

from pathlib import Path

import lint_modules
import pytest


@pytest.fixture
def complaints(tmp_path: Path, monkeypatch, capsys):
    """Write modules, by their paths, and return what is said of them."""
    monkeypatch.setattr(lint_modules, "ROOT", tmp_path)
    monkeypatch.setattr(lint_modules, "SAME_NAME", {})
    listed = tmp_path / "unmeasured_constants.txt"
    listed.touch()
    monkeypatch.setattr(lint_modules, "UNMEASURED", listed)

    def said(**sources: str) -> list[str]:
        (tmp_path / "robot").mkdir(exist_ok=True)
        for name, source in sources.items():
            (tmp_path / "robot" / f"{name}.py").write_text(source)
        failed = lint_modules.main()
        lines = capsys.readouterr().out.splitlines()
        assert failed == bool(lines)
        return lines

    return said


@pytest.mark.parametrize(
    ("sentence", "named"),
    [
        ("A participant of DDS that looks like a node of ROS 2.", True),
        ("How processes take part: participants, and their sockets.", True),
        ("The node that other nodes see.", True),
        ("Keeps a process's UDP sockets to this machine.", False),
        ("What a robot is to all the others. A participant.", False),
    ],
)
def test_the_first_sentence_has_a_word_of_the_name_or_two_of_its_text(complaints, sentence, named):
    source = (
        f'"""{sentence}"""\n\n'
        'def confine() -> None:\n    """Keep UDP sockets to this machine."""\n\n'
        'class Participant:\n    """A node as other nodes see it."""\n'
    )
    lines = complaints(participant=source)
    names = ["robot/participant.py:1: the first sentence names neither the file nor Participant"]
    assert lines == ([] if named else names)


def test_a_constant_belongs_above_the_second_definition_unless_it_is_made_of_one(complaints):
    source = (
        '"""Late."""\n\ndef late(): ...\n\nEARLY = 1\n\nclass Late: ...\n\n'
        "MADE = Late()\nOF_MADE = [MADE]\nLATER: int = 2\n"
    )
    assert complaints(late=source) == ["robot/late.py:11: LATER belongs to the top"]


def test_a_number_that_decides_is_explained(complaints, tmp_path: Path):
    room = tmp_path / "robot" / "driving"
    protocol = tmp_path / "sim" / "hat"
    room.mkdir(parents=True)
    protocol.mkdir(parents=True)
    (room / "gates.py").write_text(
        'GATE = 0.03\n"""Half: nothing changes."""\nLEAST, MOST = 1, 2\n'
        'SD = np.diag([0.1, 0.2])\nNAMES = ("late",)\nTABLE = made(3)\nON = True\n'
    )
    (protocol / "letters.py").write_text("STX = 2\n")
    assert complaints() == [
        "robot/driving/gates.py:3: LEAST, MOST has no text that says what it is, and why",
        "robot/driving/gates.py:4: SD has no text that says what it is, and why",
    ]


def test_a_number_that_decides_is_measured_or_listed_with_the_reason(complaints, tmp_path: Path):
    room = tmp_path / "robot" / "driving"
    room.mkdir(parents=True)
    (room / "gates.py").write_text(
        'GATE = 0.03\n"""Half of it: 2 % are missed."""\nROWS = 3\n"""Rows at a time."""\n'
        'LEAST, MOST = 1, 2\n"""Most counts half."""\nHELD = 1.0\n"""With 2 nothing changes."""\n'
    )
    listed = tmp_path / "unmeasured_constants.txt"
    listed.write_text(
        "# Why.\n[Sizes]\nrobot/driving/gates.py: ROWS\n    HELD GONE\nrobot/driving/no.py: GATE\n"
    )
    assert [line.partition(" (")[0] for line in complaints()] == [
        "robot/driving/gates.py:5: LEAST does not say what half and twice change, and neither"
        " docs/constants.md nor unmeasured_constants.txt has it",
        "robot/driving/gates.py:5: MOST does not say what half and twice change, and neither"
        " docs/constants.md nor unmeasured_constants.txt has it",
        "robot/driving/gates.py:7: HELD is measured, and still on the list",
        "unmeasured_constants.txt:4: robot/driving/gates.py has no number GONE that decides",
        "unmeasured_constants.txt:5: robot/driving/no.py has no number GATE that decides",
    ]


def test_a_measurement_in_the_table_counts_for_the_value_that_it_was_made_with(
    complaints, tmp_path: Path
):
    room = tmp_path / "robot" / "driving"
    room.mkdir(parents=True)
    (tmp_path / "docs").mkdir()
    (room / "gates.py").write_text(
        'GATE, NEAR = 0.03, 2 * 0.1\n"""Gates."""\nFAR = math.radians(5)\n"""Far."""\n'
    )
    table = tmp_path / "docs" / "constants.md"
    rows = [
        "| file | constant | value | what it is |",
        "| robot/driving/gates.py | GATE | 0.03 | Gates. |",
        "| robot/driving/gates.py | NEAR | 2 * 0.1 | Gates. |",
        "| robot/driving/gates.py | FAR | math.radians(5) | Far. |",
    ]
    table.write_text("\n".join(rows))
    assert complaints() == []
    (tmp_path / "unmeasured_constants.txt").write_text("robot/driving/gates.py: FAR\n")
    rows.append("| robot/driving/gates.py | GONE | 1 | Gone. |")
    table.write_text("\n".join(rows).replace("0.03", "0.04"))
    assert [line.partition(" (")[0] for line in complaints()] == [
        "robot/driving/gates.py:1: GATE is 0.03, and docs/constants.md has measured 0.04",
        "robot/driving/gates.py:3: FAR is measured, and still on the list",
        "docs/constants.md: robot/driving/gates.py has no number GONE that decides",
    ]


def test_a_public_class_has_a_name_of_its_own(complaints):
    source = '"""{0}."""\n\nclass Session: ...\n\nclass _Own: ...\n'
    lines = complaints(first=source.format("First"), second=source.format("Second"))
    assert [line for line in lines if "class" in line] == [
        "robot/first.py:3: class Session stands for another thing in robot/second.py:3"
    ]
