"""Drawings whose size or tape is not that of a floor are asked about, with the cure."""

from __future__ import annotations

import pickle
import re

import numpy as np
import pytest
import shapely
from tape_trials import SCANNER, STILL, camera_of, expected

from robot.fields.drawing.slits import without_slits
from robot.fields.field import FieldError
from robot.fields.svg_field import drawn_field, field_of_drawing
from robot.geometry import Pose2
from robot.interface import Frame

SVG = 'xmlns="http://www.w3.org/2000/svg"'
PT, PX, DOTS = 72 / 25.4, 96 / 25.4, 300 / 25.4


def ring(size: str, unit: float, tape: float = 50, digits: int = 3) -> str:
    """A floor of 1400 mm x 1200 mm, drawn in units of which a millimetre has so many."""
    box = " ".join(f"{side * unit:.{digits}f}" for side in (200, 200, 1000, 800))
    x, y, width, height = box.split()
    return (
        f'<svg {SVG} {size}><rect x="{x}" y="{y}" width="{width}" height="{height}" fill="none" '
        f'stroke="#000" stroke-width="{tape * unit:.{digits}f}"/></svg>'
    )


def sides(unit: float, suffix: str = "", digits: int = 3) -> str:
    width, height = (f"{side * unit:.{digits}f}" for side in (1400, 1200))
    return f'width="{width}{suffix}" height="{height}{suffix}" viewBox="0 0 {width} {height}"'


def box(unit: float, digits: int = 3) -> str:
    return f'viewBox="0 0 {1400 * unit:.{digits}f} {1200 * unit:.{digits}f}"'


ASKED = {
    "points without a unit": (ring(sides(PT), PT), "142 mm wide: was this drawn in points"),
    "pixels without a unit": (ring(sides(PX), PX), "189 mm wide: was this drawn in pixels"),
    "300 dpi without a unit": (ring(sides(DOTS), DOTS), "591 mm wide: was this drawn in dots"),
    "Illustrator, a viewBox alone": (ring(box(PT, 2), PT), "was this drawn in points"),
    "Affinity, 100 %": (
        ring(f'width="100%" height="100%" {box(PX, 0)}', PX), "was this drawn in pixels"),
    "300 dpi called pixels": (ring(sides(DOTS, "px"), DOTS), "156 mm wide: was this drawn in dots"),
    "millimetres called pixels": (
        ring(sides(1, "px"), 1), "13.2 mm wide: was this drawn in millimetres"),
    "centimetres": (ring(box(0.1), 0.1), "5 mm wide: was this drawn in centimetres"),
    "millimetres without a viewBox": (
        ring('width="1400mm" height="1200mm"', 1), "13.2 mm wide: was this drawn in millimetres"),
    "narrow tape in points": (
        ring(sides(PT), PT, tape=19), "3968.5 x 3401.57 mm: was this drawn in points"),
    "narrow tape in pixels": (
        ring(sides(PX), PX, tape=25), "5291.34 x 4535.43 mm: was this drawn in pixels"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("kind", ASKED)
def test_a_unit_that_nobody_can_have_meant_is_asked_about(kind: str) -> None:
    text, question = ASKED[kind]
    with pytest.raises(FieldError, match=re.escape(question)) as asked:
        field_of_drawing(text, "drawing")
    told = str(asked.value)
    assert "\n" not in told and len(told) < 400

    # The cure that it names makes the floor that was meant.
    cure = re.search(r'width="\S+mm" height="\S+mm"( viewBox="[^"]+")?', told)
    assert cure is not None
    old = re.search(r"<svg [^>]*>", text)
    assert old is not None
    kept = re.findall(r'viewBox="[^"]+"', old[0]) if cure[1] is None else []
    cured = text.replace(old[0], f"<svg {SVG} {' '.join([cure[0], *kept])}>")
    field = field_of_drawing(cured, "drawing")
    assert field.extent == pytest.approx((0, -1.2, 1.4, 0), abs=0.002)
    xmin, ymin, xmax, ymax = field.drive_area
    assert (xmax - xmin, ymax - ymin) == pytest.approx(
        (1 + field.tape_width, 0.8 + field.tape_width), abs=0.002
    )

    # And so does the answer that it names: the floor is as it was drawn.
    answer = re.search(r'data-tape="\S+"', told)
    assert answer is not None
    same = field_of_drawing(text.replace("<svg ", f"<svg {answer[0]} ", 1), "drawing")
    assert same.tape_width == pytest.approx(float(answer[0][11:-1]) / 1000, rel=0.01)


def test_the_answer_must_be_true() -> None:
    text = ring(sides(1, "mm"), 1)
    assert field_of_drawing(text.replace("<svg ", '<svg data-tape="50mm" '), "x").tape_width == 0.05
    with pytest.raises(FieldError, match="data-tape is '19', but the tape is 50 mm wide"):
        field_of_drawing(text.replace("<svg ", '<svg data-tape="19" '), "x")
    with pytest.raises(FieldError, match="data-tape is 'wide'; valid is the tape's width"):
        field_of_drawing(text.replace("<svg ", '<svg data-tape="wide" '), "x")


@pytest.mark.parametrize("tape", [15, 19, 24, 38, 50, 100])
@pytest.mark.parametrize(
    ("size", "unit"),
    [(sides(1, "mm"), 1), (sides(1), 1), (box(1), 1), (sides(PT, "pt"), PT), (sides(PX, "px"), PX),
     ('width="1400mm" height="1200mm"', PX), ('width="1400" height="1200"', 1),
     ('width="140cm" height="120cm" viewBox="0 0 14 12"', 0.01)],
)  # fmt: skip
def test_usual_tape_in_a_usual_unit_is_no_question(size: str, unit: float, tape: float) -> None:
    field = field_of_drawing(ring(size, unit, tape, digits=6), "drawing")
    assert field.tape_width == pytest.approx(tape / 1000, abs=1e-6)
    assert field.extent == pytest.approx((0, -1.2, 1.4, 0), abs=1e-5)


# --- gaps that no camera sees --------------------------------------------------------------------


def arc_of_lines(count: int) -> str:
    turns = np.linspace(0, 2 * np.pi, count + 1)
    x, y = 700 + 450 * np.cos(turns), 600 + 450 * np.sin(turns)
    lines = "".join(
        f'<line x1="{x[k]:.3f}" y1="{y[k]:.3f}" x2="{x[k + 1]:.3f}" y2="{y[k + 1]:.3f}"/>'
        for k in range(count)
    )
    return (
        f'<svg {SVG} {sides(1, "mm")}><g fill="none" stroke="black" stroke-width="50">{lines}</g>'
        "</svg>"
    )


@pytest.mark.slow
@pytest.mark.parametrize("count", [400, 700, 1500])
def test_a_circle_of_unjoined_lines_is_two_circles_of_edges(count: int) -> None:
    edges = field_of_drawing(arc_of_lines(count), "drawing").edges
    radii = np.hypot(*(edges.reshape(-1, 2) - [0.7, -0.6]).T)
    assert np.minimum(np.abs(radii - 0.475), np.abs(radii - 0.425)).max() < 0.0005
    faces = shapely.polygonize(shapely.linestrings(edges.reshape(-1, 2, 2)))
    assert len(shapely.get_parts(faces)) == 2


def cut(whole: shapely.Geometry, gap: float, length: float) -> shapely.Geometry:
    """Cut a slit of a width and a length [m] into tape, from its left end."""
    return shapely.difference(whole, shapely.box(-1, 0.05, length, 0.05 + gap))


STRIPS = shapely.box(0, 0, 1, 0.1)


@pytest.mark.parametrize(("gap", "length"), [(0.0003, 2), (0.0009, 2), (0.0015, 2), (0.0015, 0.03)])
def test_gaps_that_a_camera_sees_stay(gap: float, length: float) -> None:
    tape = cut(STRIPS, gap, length)
    assert without_slits(tape, 0.05) is tape


@pytest.mark.parametrize(
    ("gap", "length"), [(0.0001, 2), (0.0002, 2), (0.0004, 0.07), (0.0009, 0.05)]
)
def test_narrower_gaps_are_closed_and_all_else_stays(gap: float, length: float) -> None:
    whole = shapely.difference(STRIPS, shapely.Polygon([(0.3, 0), (0.5, 0.03), (0.4, 0)]))
    closed = without_slits(cut(whole, gap, length), 0.05)
    assert shapely.area(shapely.symmetric_difference(closed, whole)) < 1e-9


def two_strips(gap: float) -> str:
    """Two strips of 5 cm across the robot's way, a gap [mm] apart."""
    return (
        f'<svg {SVG} width="1600mm" height="1600mm" viewBox="-800 -800 1600 1600">'
        f'<path d="M 225 -700 V 700 M {275 + gap} -700 V 700" stroke="black" stroke-width="50" '
        'fill="none"/></svg>'
    )


@pytest.mark.parametrize("gap", [0.2, 0.4, 0.7, 0.95, 1.5])
def test_a_map_of_two_strips_has_what_the_scanner_sees(gap: float) -> None:
    field = field_of_drawing(two_strips(gap), "strips")
    camera, right = camera_of(field), []
    for robot in (Pose2(x, 0.0, theta) for x in (-0.06, 0.06) for theta in (0.0, 0.6)):
        scan = SCANNER.scan(Frame(0.0, camera.picture(robot, STILL))).scan
        ranges, begins = scan.ranges[scan.hit], expected(field, robot, SCANNER)[0][scan.hit]
        right += (np.abs(ranges - begins) < 0.004).tolist()
    assert len(right) > 200 or gap == 0.2  # these are one strip, which is too wide for tape
    assert np.mean(right) > 0.97


# --- one plain function --------------------------------------------------------------------------


def test_a_field_goes_through_a_pipe() -> None:
    field = drawn_field(ring(sides(1, "mm"), 1).encode(), "drawing")
    copy = pickle.loads(pickle.dumps(field))
    assert (copy.edges == field.edges).all() and (copy.floor.image == field.floor.image).all()
    assert (copy.tape, copy.start, copy.extent) == (field.tape, field.start, field.extent)
    assert pickle.loads(pickle.dumps(drawn_field)) is drawn_field
