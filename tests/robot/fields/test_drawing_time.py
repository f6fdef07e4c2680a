"""The time that a drawing takes grows as its size does, whatever is long in it."""

from __future__ import annotations

import gc
from time import process_time

import pytest

from robot.fields.field import FieldError
from robot.fields.svg_field import drawn_field, field_of_drawing

pytestmark = pytest.mark.slow

TAPE = 'fill="none" stroke="#222" stroke-width="30"'
ROAD = f'<path d="M -600 0 H 600" {TAPE}/>'


def page(content: str) -> str:
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" width="500mm" height="250mm" '
        f'viewBox="-250 -125 500 250">{ROAD}{content}</svg>'
    )


def path(**attributes: str) -> str:
    written = {"d": "M 0 0 h 100", "fill": "none", "stroke": "#222", "stroke-width": "30"}
    joined = " ".join(f'{name}="{value}"' for name, value in (written | attributes).items())
    return page(f"<path {joined}/>".replace("stroke_", "stroke-"))


def zigzag(count: int) -> str:
    return " ".join(f"{k * 1000 / count:.3f},{300 * (k % 2)}" for k in range(count))


def lines(count: int, more: str = "") -> str:
    return "".join(
        f'<path d="M {-900 + k % 60 * 30} {-300 + k // 60} h 20" {TAPE} {more}/>'
        for k in range(count)
    )


KINDS = {
    "transforms": (12_500, lambda n: path(transform="translate(1 2) " * n)),
    "transform, cut off": (12_500, lambda n: path(transform="translate(" * n)),
    "transform, digits": (50_000, lambda n: path(transform=f"translate({'1' * n}x)")),
    "transform, spaces": (50_000, lambda n: path(transform=f"translate(1 {' ' * n}")),
    "transform, words": (50_000, lambda n: path(transform="a" * n)),
    "d": (500, lambda n: path(d="M -500 0" + " l 9 3 9 -3" * n)),
    "d, digits": (100_000, lambda n: path(d="M 0 0 h 1" + "0" * n)),
    "d, one wrong letter": (100_000, lambda n: path(d="M 0 0 h 1" + " 1" * n + "x")),
    "d, points": (100_000, lambda n: path(d="M 0 0" + "." * n)),
    "d, moves": (50_000, lambda n: path(d="M 0 0" * n + "h 100")),
    "d, curves": (50, lambda n: path(d="M -900 0" + " q 40 9 80 0 q 40 9 -80 60" * n)),
    "style": (4_000, lambda n: path(style="stroke:#111;a:b;" * n)),
    "style, open brackets": (20_000, lambda n: path(style="a:" + "(" * n)),
    "style, quotes": (20_000, lambda n: path(style="a:'" * n)),
    "style, variables": (2_000, lambda n: path(style="stroke:" + "var(--a," * n)),
    "class": (20_000, lambda n: path(**{"class": " ".join(f"a{k}" for k in range(n))})),
    "points": (2_000, lambda n: page(f'<polyline points="{zigzag(n)}" {TAPE}/>')),
    "points, filled": (1_000, lambda n: page(f'<polygon points="{zigzag(n)}" fill="#aaa"/>')),
    "points, wrong": (50_000, lambda n: page(f'<polyline points="{"1 " * n}x" {TAPE}/>')),
    "points, digits": (50_000, lambda n: page(f'<polyline points="{"1" * n}x" {TAPE}/>')),
    "dashes": (10_000, lambda n: path(stroke_dasharray="9 " * n)),
    "a colour": (50_000, lambda n: path(stroke="rgb(" * n)),
    "a paint": (50_000, lambda n: path(stroke="url(" + " " * n)),
    "a viewBox": (50_000, lambda n: page(f'<svg viewBox="{"0 " * n}">{ROAD}</svg>')),
    "an id": (200_000, lambda n: path(id="a" * n)),
    "nesting": (15, lambda n: page("<g>" * n + lines(20) + "</g>" * n)),
    "nested clips": (
        15,
        lambda n: page(
            '<clipPath id="c"><rect x="-900" y="-400" width="1800" height="800"/></clipPath>'
            + '<g clip-path="url(#c)">' * n + lines(20) + "</g>" * n
        ),
    ),
    "nested opacities": (15, lambda n: page('<g opacity=".9">' * n + ROAD + "</g>" * n)),
    "shapes": (500, lambda n: page(lines(n))),
    "shapes within an opacity": (300, lambda n: page(f'<g opacity=".9">{lines(n)}</g>')),
    "shapes, each with an opacity": (300, lambda n: page(lines(n, 'opacity=".9"'))),
    "shapes and paint over them": (
        150,
        lambda n: page(
            "".join(
                f'<path d="M {-900 + k} -300 v 600" {TAPE}/>'
                f'<rect x="{-900 + k}" y="{k % 200}" width="3" height="90" fill="#fff"/>'
                for k in range(n)
            )
        ),
    ),
    "fills": (
        400,
        lambda n: page("".join(f'<rect x="{k % 900}" width="9" height="9"/>' for k in range(n))),
    ),
    "uses": (
        400, lambda n: page("<defs>" + lines(1, 'id="a"') + "</defs>"
                            + "".join(f'<use href="#a" y="{k % 600}"/>' for k in range(n))),
    ),
    "uses of uses": (
        15,
        lambda n: page(
            f'<path id="u0" d="M 0 0 h 100" {TAPE}/>'
            + "".join(f'<g id="u{k}"><use href="#u{k - 1}"/></g>' for k in range(1, n))
        ),
    ),
    "clips": (
        150,
        lambda n: page(
            '<clipPath id="c"><rect x="-900" y="-400" width="1800" height="800"/></clipPath>'
            + lines(n, 'clip-path="url(#c)"')
        ),
    ),
    "gradients": (
        500,
        lambda n: page(
            '<path d="M 0 0 h 9" stroke="url(#g0)"/>'
            + "".join(f'<linearGradient id="g{k}" href="#g{k + 1}"/>' for k in range(n))
        ),
    ),
    "rules": (
        500,
        lambda n: page(
            "<style>" + "".join(f".c{k}{{stroke:#{k:06x}}}" for k in range(n)) + "</style>"
            + "".join(f'<path class="c{k}" d="M 0 {k % 300} h 9" {TAPE}/>' for k in range(n))
        ),
    ),
    "a chain of selectors": (
        1_000, lambda n: page(f"<style>{'g ' * n}path{{stroke:#111}}</style>{'<g>' * 30}{ROAD}"
                              + "</g>" * 30),
    ),
    "selectors within selectors": (
        1_000, lambda n: page(f"<style>{':not(' * n}path{')' * n}{{stroke:#111}}</style>{ROAD}"),
    ),
    "siblings of siblings": (
        300, lambda n: page("<style>path~path~path:nth-last-of-type(2n+1){stroke:#111}</style>"
                            + lines(n)),
    ),
    "comments": (20_000, lambda n: page("<style>" + "/*" * n + "</style>" + "<!-- -->" * n)),
    "entities": (
        50, lambda n: f'<!DOCTYPE svg [<!ENTITY e "{"a" * 200}">]>' + page(
            f'<desc>{"&e;" * n}</desc>'),
    ),
    "attributes": (5_000, lambda n: path(**{f"a{k}": "b" for k in range(n)})),
}  # fmt: skip


def seconds(text: str) -> float:
    """Processor time of one reading, which may end in a refusal."""
    drawn_field.cache_clear()
    gc.collect()
    gc.disable()  # it looks through all that other tests have left
    begin = process_time()
    try:
        field_of_drawing(text, "drawing")
    except FieldError as refusal:
        assert len(str(refusal)) < 600
    finally:
        gc.enable()
    return process_time() - begin


@pytest.mark.parametrize("kind", KINDS)
def test_four_times_the_size_takes_less_than_eight_times_as_long(kind: str) -> None:
    size, make = KINDS[kind]
    small, large = make(size), make(4 * size)
    # What takes next to nothing is compared with a twentieth of a second.
    for _ in range(3):
        before, after = max(seconds(small), 0.05), seconds(large)
        if after < 8 * before:
            return
    assert after < 8 * before
