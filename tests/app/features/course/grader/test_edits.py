"""Edits: each is a program that Python can read, and the one that mends a slip is among them."""

from __future__ import annotations

import ast

import pytest
from course.solutions import BASES

from app.features.course.grader.causes.causes import CAUSES
from app.features.course.grader.edits import mended

RIGHT = """
def area(width, height):
    half = width * height / 2
    return [half, max(half, 1)]
"""


@pytest.mark.parametrize(
    ("wrong", "cause"),
    [
        (("width * height", "width / height"), "slip-operator"),
        (("height / 2", "height / 3"), "slip-number"),
        (("height / 2", "width / 2"), "slip-name"),
        (("max(half", "min(half"), "slip-function"),
        (("width * height / 2", "-width * height / 2"), "slip-sign"),
        (("width * height / 2", "width * abs(height) / 2"), "slip-too-much"),
        (("[half, max(half, 1)]", "[max(half, 1), half]"), "slip-order"),
        (("width * height / 2", "width * height"), "slip-missing"),
    ],
)
def test_one_edit_makes_a_wrong_program_right(wrong, cause):
    source = RIGHT.replace(*wrong)
    assert source != RIGHT
    due = [_result(RIGHT, sides) for sides in ((2.0, 3.0), (5.0, -0.25))]
    for edit, changed in mended(source, ["area"]):
        if [_result(changed, sides) for sides in ((2.0, 3.0), (5.0, -0.25))] == due:
            assert edit.cause == cause
            assert edit.line in (3, 4)
            return
    pytest.fail("no edit mends it")


def _result(source, sides):
    names = {}
    try:
        exec(source, names)
        return names["area"](*sides)
    except Exception as error:
        return repr(error)


def test_edits_leave_the_program_as_it_was():
    before = ast.unparse(ast.parse(BASES["loops"]))
    changed = [source for _, source in mended(BASES["loops"], ["odometry"])]
    assert before not in changed
    assert len(set(changed)) > len(changed) / 2
    assert all("def inject(" in source for source in changed[::100])


def test_all_causes_of_edits_have_words():
    causes = {edit.cause for edit, _ in mended(BASES["arrays"], ["log_weight", "motion"])}
    assert causes <= set(CAUSES)
    assert "slip-sign" in causes


@pytest.mark.parametrize("counted", ["range(len(values) - 1)", "range(1, len(values))"])
def test_a_range_that_is_one_too_short_is_not_told_as_brackets(counted):
    wrong = f"def total(values):\n    return sum(values[place] for place in {counted})\n"
    for edit, changed in mended(wrong, ["total"]):
        names = {}
        try:
            exec(changed, names)
            right = names["total"]([3, 4, 5]) == 12
        except Exception:
            continue
        if right:
            assert edit.cause == "slip-range"
            return
    pytest.fail("no edit mends it")


@pytest.mark.parametrize(
    ("wrong", "right"),
    [
        (
            "HALF = 3\n\ndef area(width, height):\n    return width * height / HALF\n",
            "HALF = 2\n\ndef area(width, height):\n    return width * height / HALF\n",
        ),
        (
            "class Room:\n    def area(self, w, h):\n        return w / h\n"
            "def area(w, h):\n    return Room().area(w, h)\n",
            "class Room:\n    def area(self, w, h):\n        return w * h\n"
            "def area(w, h):\n    return Room().area(w, h)\n",
        ),
    ],
    ids=("a value of the file", "a class"),
)
def test_what_a_function_uses_is_changed_too(wrong, right):
    changed = [source for _, source in mended(wrong, ["area"])]
    assert ast.unparse(ast.parse(right)) in [ast.unparse(ast.parse(each)) for each in changed]


def test_a_copy_mends_two_names_for_one_array_and_can_be_asked_for_alone():
    source = (
        "def doubled(values):\n"
        "    new = values\n"
        "    for place in range(1, len(values)):\n"
        "        new[place] = values[place - 1] + values[place]\n"
        "    return new\n"
    )
    asked = list(mended(source, ["doubled"], "same-array"))
    assert {edit.cause for edit, _ in asked} == {"same-array"}
    given = []
    for edit, changed in asked:
        names = {}
        exec(changed, names)
        given.append((edit.line, names["doubled"]([1, 2, 3])))
    assert (2, [1, 3, 5]) in given


@pytest.mark.parametrize(
    ("wrong", "right", "cause"),
    [
        ("a = a + b\nc = c * a\nd = d * a\n", "c = c * a\nd = d * a\na = a + b\n", "slip-order"),
        ("a = a - b\nb = a + b\n", "(a, b) = (a - b, a + b)\n", "slip-order"),
        (
            "for a in b:\n    c = a\n    d = c\n    b = 1\n",
            "c = a\nd = c\nfor a in b:\n    b = 1\n",
            "slip-order",
        ),
        (
            "for a in b:\n    c = a\n    return c\n",
            "for a in b:\n    c = a\nreturn c\n",
            "slip-order",
        ),
        ("if a:\n    c = a\n    return c\n", "if a:\n    c = a\nreturn c\n", "slip-order"),
        ("if a:\n    b = a\nc = a\n", "if a:\n    b = a\n    c = a\n", "slip-order"),
        (
            "for a in b:\n    if a:\n        c = a\n",
            "for a in b:\n    if a:\n        c = a\n        break\n",
            "slip-break",
        ),
        ("return a * a < b\n", "return (a * a) ** 0.5 < b\n", "slip-missing"),
        ("a = atan2(b, c)\n", "a = b / c\n", "slip-function"),
        ("a = b.u0 / sin(c)\n", "a = b.u0 / sin(c + b.v0)\n", "slip-missing"),
    ],
)
def test_each_way_to_mend_is_tried(wrong, right, cause):
    head = "def task(a, b, c, d):\n"
    source, due = (
        head + "".join(f"    {line}\n" for line in text.splitlines()) for text in (wrong, right)
    )
    causes = [
        edit.cause
        for edit, changed in mended(source, ["task"])
        if changed == ast.unparse(ast.parse(due))
    ]
    assert causes[:1] == [cause]


def test_an_angle_is_brought_back_where_nothing_else_mends_it():
    source = "def turn(angle):\n    angle = angle + 1\n    return angle\n"
    tried = [edit for edit, _ in mended(source, ["turn"])]
    brought_back = [place for place, edit in enumerate(tried) if edit.cause == "E2"]
    operators = [place for place, edit in enumerate(tried) if edit.kind[0] == "operator"]
    assert operators
    assert brought_back[0] > operators[-1]
