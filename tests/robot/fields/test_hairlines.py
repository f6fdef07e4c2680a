"""Drawings of CAD programs, whose lines are hairlines: refused with the cure, which works."""

from __future__ import annotations

import re

import pytest

from app.languages.catalogue import catalogue
from robot.fields.field import FieldError
from robot.fields.svg_field import field_of_drawing

SVG = 'xmlns="http://www.w3.org/2000/svg"'
INKSCAPE = "stroke:#000;stroke-width:1px;vector-effect:non-scaling-stroke;-inkscape-stroke:hairline"


def page(lines: str, size: str = 'width="2000mm" height="1000mm" viewBox="0 0 2000 1000"') -> str:
    return f"<svg {SVG} {size}>{lines}</svg>"


def line(how: str, scale: float = 1.0) -> str:
    x, y, end = 100 * scale, 500 * scale, 1900 * scale
    return f'<path d="M{x:g} {y:g}H{end:g}" fill="none" {how}/>'


def refused(drawing: str) -> str:
    with pytest.raises(FieldError) as caught:
        field_of_drawing(drawing, "drawing")
    told = str(caught.value)
    assert "\n" not in told and len(told) < 400
    # People who read German are told so, too, in whole.
    german = catalogue("de").translated(told)
    assert not re.search(r"\b(is|the|its|give|if)\b", german)
    return told


ZERO = {
    "an attribute": 'stroke="#000" stroke-width="0"',
    "with a unit": 'stroke="#000" stroke-width="0mm"',
    "in a style": 'style="stroke:black;stroke-width:0"',
    "too small for a number": 'stroke="#000" stroke-width="1e-9"',
}


@pytest.mark.parametrize("how", ZERO)
@pytest.mark.parametrize(
    ("size", "scale"),
    [
        ('width="2000mm" height="1000mm" viewBox="0 0 2000 1000"', 1),
        ('width="2000mm" height="1000mm" viewBox="0 0 200 100"', 0.1),
        ('viewBox="0 0 2000 1000"', 1),
    ],
)
def test_lines_of_no_width_are_named_and_their_cure_is_tape(
    how: str, size: str, scale: float
) -> None:
    told = refused(page(line(ZERO[how], scale), size))
    assert "hairline" in told
    cure = re.search(r'stroke-width="[\d.]+"', told)
    assert cure is not None
    field = field_of_drawing(page(line(f'stroke="#000" {cure[0]}', scale), size), "drawing")
    assert field.tape_width == pytest.approx(0.05)


def test_a_line_cannot_be_filled() -> None:
    told = refused(page('<line x1="100" y1="9" x2="900" y2="9" stroke="#000" stroke-width="0"/>'))
    assert "lines have the stroke-width 0" in told


def test_shapes_without_a_stroke_are_no_hairlines() -> None:
    told = refused(page('<rect width="9" height="9" stroke="#000" stroke-width="0"/>'))
    assert "hairline" not in told


def test_among_tape_lines_of_no_width_are_what_a_browser_shows() -> None:
    tape = line('stroke="#000" stroke-width="50"')
    field = field_of_drawing(page(tape + line(ZERO["in a style"]) + tape), "drawing")
    assert field.tape_width == 0.05


THIN = {
    "0.01 mm": 'stroke="#000" stroke-width="0.01"',
    "0.1 mm": 'stroke="#000" stroke-width="0.1"',
    "0.25 mm": 'stroke="#000" stroke-width="0.25"',
    "a pixel": 'stroke="#000" stroke-width="1" vector-effect="non-scaling-stroke"',
    "Inkscape's": f'style="{INKSCAPE}"',
}


@pytest.mark.parametrize("how", THIN)
@pytest.mark.parametrize("group", ["", ' transform="scale(2)"'])
def test_thin_lines_are_named_and_their_cure_is_tape(how: str, group: str) -> None:
    scale = 0.5 if group else 1.0

    def drawn(how: str) -> str:
        return page(f"<g{group}>{line(how, scale)}</g>")

    told = refused(drawn(THIN[how]))
    assert "hairline" in told
    factor = re.search(r"stroke-width ([\d.e+]+) times as large", told)
    width = re.search(r"""stroke-width(="|:)([\d.]+)""", THIN[how])
    assert factor is not None and width is not None
    wide = f"{float(width[2]) * float(factor[1]):g}"
    start, end = width.span(2)
    field = field_of_drawing(drawn(THIN[how][:start] + wide + THIN[how][end:]), "drawing")
    assert field.tape_width == pytest.approx(0.05, rel=0.01)


def test_thin_lines_beside_tape_are_named_too() -> None:
    tape = line('stroke="#000" stroke-width="50"')
    told = refused(page(tape + '<path d="M9 9h99" stroke="#000" stroke-width="0.18" fill="none"/>'))
    assert "0.18 mm wide" in told
    assert "if it is no tape, remove it" in told


@pytest.mark.parametrize("width", [1, 1.4, 2])
def test_wide_pens_of_cad_are_asked_about_with_the_cure(width: float) -> None:
    told = refused(page(line(f'stroke="#000" stroke-width="{width}"')))
    factor = re.search(r"stroke-width ([\d.e+]+) times as large", told)
    assert factor is not None
    wide = f'stroke="#000" stroke-width="{width * float(factor[1]):g}"'
    assert field_of_drawing(page(line(wide)), "x").tape_width == pytest.approx(0.05, rel=0.01)


def test_a_drawing_in_metres_is_asked_about() -> None:
    told = refused(page(line('stroke="#000" stroke-width="0.05"', 0.001), 'viewBox="0 0 12 11"'))
    assert "or if it was drawn in metres, give the <svg>" in told
    assert 'width="12000mm" height="11000mm"' in told


def test_the_word_hairline_is_named_with_the_cure() -> None:
    with pytest.raises(FieldError, match=r"stroke-width is 'hairline'.* as wide as the tape"):
        field_of_drawing(page(line('stroke="#000" stroke-width="hairline"')), "drawing")
