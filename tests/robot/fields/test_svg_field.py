import math

import numpy as np
import pytest
import shapely
from floor_looks import grey_at
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robot.fields.edges import lengths
from robot.fields.svg_field import load_svg

SVG = 'xmlns="http://www.w3.org/2000/svg"'
PAGE = f'<svg {SVG} width="2000" height="1000" viewBox="-1000 -500 2000 1000"'
TAPE = 'stroke="#222" stroke-width="50" fill="none"'


@pytest.fixture
def drawing(tmp_path):
    """Loads a field from SVG text."""

    def load(text):
        path = tmp_path / "drawing.svg"
        path.write_text(text, encoding="utf-8")
        return load_svg(path)

    return load


def page(content, attributes=""):
    return f"{PAGE} {attributes}>{content}</svg>"


def dark_area(field):
    """The tape's polygons, put together again from the edges."""
    faces = shapely.get_parts(
        shapely.polygonize(shapely.linestrings(field.edges.reshape(-1, 2, 2)))
    )
    edges = field.edges
    signed = (edges[:, 0] * edges[:, 3] - edges[:, 2] * edges[:, 1]).sum() / 2
    dark = [face for face in faces if on_dark_side(field, face)]
    area = shapely.union_all(dark)
    assert area.area == pytest.approx(signed)
    return area


def on_dark_side(field, face):
    inside = face.point_on_surface()
    nearest = shapely.distance(shapely.linestrings(field.edges.reshape(-1, 2, 2)), inside).argmin()
    offset = [inside.x, inside.y] - field.edges[nearest, :2]
    return float(offset @ field.normals[nearest]) < 0


# --- frames and units ----------------------------------------------------------------------------


def test_the_drawings_own_origin_is_the_maps_and_y_points_up(drawing):
    field = drawing(page(f'<line x1="100" y1="-200" x2="300" y2="-200" {TAPE}/>'))
    assert dark_area(field).bounds == pytest.approx((0.1, 0.175, 0.3, 0.225))
    assert field.floor.extent == pytest.approx((-1.0, -0.5, 1.0, 0.5))


@pytest.mark.parametrize(
    "size",
    ['width="400mm" height="200mm"', 'width="40cm" height="20cm"', 'width="400" height="200"',
     'width="400mm"', 'height="20cm"', 'width="15.748031496062993in" height="7.874015748031496in"'],
)  # fmt: skip
def test_the_viewbox_is_scaled_to_the_size_in_any_unit(drawing, size):
    field = drawing(
        f'<svg {SVG} {size} viewBox="-10 -5 20 10">'
        '<line x1="0" y1="0" x2="5" y2="0" stroke="black" stroke-width="2"/></svg>'
    )
    assert field.floor.extent == pytest.approx((-0.2, -0.1, 0.2, 0.1))
    assert dark_area(field).bounds == pytest.approx((0, -0.02, 0.1, 0.02))
    assert field.tape_width == pytest.approx(0.04)


def test_without_a_viewbox_and_a_unit_all_is_in_millimetres_from_the_top_left(drawing):
    field = drawing(f'<svg {SVG} width="400" height="200"><path d="M50 50h100" {TAPE}/></svg>')
    assert field.floor.extent == pytest.approx((0, -0.2, 0.4, 0))
    assert dark_area(field).bounds == pytest.approx((0.05, -0.075, 0.15, -0.025))


@pytest.mark.parametrize(
    "size",
    ['width="381mm" height="254mm"', 'width="1440px" height="960px"', 'width="1440" height="254mm"',
     'width="1080pt" height="720pt"', 'width="15in" height="60pc"',
     'style="width:1440px;height:960px"'],
)  # fmt: skip
def test_without_a_viewbox_a_unit_of_a_size_with_units_is_a_96th_of_an_inch(drawing, size):
    tape = TAPE.replace("50", "96")
    field = drawing(f'<svg {SVG} {size}><path d="M192 192h384" {tape}/></svg>')
    assert field.floor.extent == pytest.approx((0, -0.254, 0.381, 0))
    assert dark_area(field).bounds == pytest.approx((0.0508, -0.0635, 0.1524, -0.0381))


def test_a_viewbox_alone_is_in_millimetres(drawing):
    field = drawing(f'<svg {SVG} viewBox="0 0 400 200"><path d="M50 50h100" {TAPE}/></svg>')
    assert field.floor.extent == pytest.approx((0, -0.2, 0.4, 0))


def test_a_viewbox_of_other_proportions_is_centred(drawing):
    field = drawing(
        f'<svg {SVG} width="400" height="200" viewBox="0 0 100 100">'
        '<path d="M0 50h100" stroke="black" stroke-width="20"/></svg>'
    )
    assert field.floor.extent == pytest.approx((-0.1, -0.2, 0.3, 0))
    assert dark_area(field).bounds == pytest.approx((0, -0.12, 0.2, -0.08))


def test_the_start_is_in_millimetres_and_degrees_with_y_up(drawing):
    field = drawing(page(f'<path d="M0 0h100" {TAPE}/>', 'data-start="-300, 200 90"'))
    assert field.start.x == pytest.approx(-0.3)
    assert field.start.y == pytest.approx(0.2)
    assert field.start.theta == pytest.approx(math.pi / 2)


def test_transforms_turn_and_scale_line_and_width(drawing):
    field = drawing(
        page(
            '<g transform="translate(100 0)"><g transform="rotate(-90) scale(2)">'
            '<line x1="0" y1="0" x2="100" y2="0" stroke="black" stroke-width="25"/></g></g>'
        )
    )
    assert dark_area(field).bounds == pytest.approx((0.075, 0, 0.125, 0.2))
    assert field.tape_width == pytest.approx(0.05)
    assert len(field.edges) == 4


def test_a_stroke_is_stretched_as_a_whole(drawing):
    field = drawing(
        page('<path d="M0 0h100" transform="scale(1 3)" stroke="black" stroke-width="20"/>')
    )
    assert dark_area(field).bounds == pytest.approx((0, -0.03, 0.1, 0.03))


def test_used_elements_are_drawn_where_they_are_used(drawing):
    field = drawing(
        page(
            f'<defs><g id="bar"><path d="M0 0h100" {TAPE}/></g></defs>'
            '<use href="#bar" x="100" y="-100"/><use href="#bar" transform="rotate(90)"/>'
        )
    )
    assert len(field.edges) == 8
    assert dark_area(field).bounds == pytest.approx((-0.025, -0.1, 0.2, 0.125))


# --- tape ----------------------------------------------------------------------------------------


def test_crossing_strokes_are_one_area(drawing):
    cross = f'<path d="M-200 0h400M0-200v400" {TAPE}/>'
    field = drawing(page(cross))
    assert len(field.edges) == 12
    assert dark_area(field).area == pytest.approx(2 * 0.4 * 0.05 - 0.05**2)


@pytest.mark.parametrize("angle", [0, 10, 33, 45, 77.7])
def test_strokes_that_go_on_in_one_line_have_no_corner_between_them(drawing, angle):
    pieces = "".join(f'<path d="M{x} 0h110" {TAPE}/>' for x in range(-300, 300, 100))
    field = drawing(page(f'<g transform="rotate({angle})">{pieces}</g>'))
    assert len(field.edges) == 4
    assert sorted(lengths(field.edges)) == pytest.approx([0.05, 0.05, 0.61, 0.61], abs=1e-6)


def test_a_circle_of_tape_is_two_circles_of_edges(drawing):
    field = drawing(page(f'<circle cx="100" cy="100" r="300" {TAPE}/>'))
    radii = np.hypot(*(field.edges.reshape(-1, 2) - [0.1, -0.1]).T)
    middles = (field.edges[:, :2] + field.edges[:, 2:]) / 2 - [0.1, -0.1]
    for found in (radii, np.hypot(*middles.T)):
        off = np.minimum(np.abs(found - 0.275), np.abs(found - 0.325))
        assert off.max() < 0.0001
    assert len(field.edges) < 600


@pytest.mark.parametrize(
    "shape",
    ['<rect x="-100" y="-50" width="200" height="100" {}/>',
     '<polygon points="-100,-50 100,-50 100,50 -100,50" {}/>',
     '<path d="M-100-50H100V50H-100Z" {}/>',
     '<polyline points="-100,-50 100,-50 100,50 -100,50 -100,-50" stroke-linecap="square" {}/>'],
)  # fmt: skip
def test_the_same_box_is_the_same_tape(drawing, shape):
    field = drawing(page(shape.format(TAPE)))
    expected = shapely.box(-0.125, -0.075, 0.125, 0.075) - shapely.box(-0.075, -0.025, 0.075, 0.025)
    assert len(field.edges) == 8
    assert dark_area(field).symmetric_difference(expected).area < 1e-9


@pytest.mark.parametrize(
    ("style", "bounds"),
    [('stroke-linecap="square"', (-0.025, 0.125)), ('stroke-linecap="round"', (-0.025, 0.125)),
     ('style="stroke-linecap:butt"', (0, 0.1))],
)  # fmt: skip
def test_caps_are_honoured(drawing, style, bounds):
    field = drawing(page(f'<path d="M0 0h100" {style} {TAPE}/>'))
    xmin, _, xmax, _ = dark_area(field).bounds
    assert (xmin, xmax) == pytest.approx(bounds, abs=1e-4)


def test_dashes_are_pieces_of_tape(drawing):
    field = drawing(page(f'<path d="M0 0h400" stroke-dasharray="100 50" {TAPE}/>'))
    assert [part.area for part in dark_area(field).geoms] == pytest.approx([0.005] * 3)


def test_styles_colours_and_inheritance_are_understood(drawing):
    field = drawing(
        page(
            "<style>.tape { stroke: rgb(10%, 10%, 10%); stroke-width: 50px; fill: none }</style>"
            '<path class="tape" d="M0 0h100"/>'
            '<g stroke="navy" stroke-width="50"><path d="M0 100h100"/></g>'
            '<path d="M0 200h100" style="stroke:#123;stroke-width:50mm"/>'
        )
    )
    assert len(shapely.get_parts(dark_area(field))) == 3


def test_light_strokes_and_all_fills_are_no_tape(drawing):
    field = drawing(
        page(
            f'<path d="M0 0h100" {TAPE}/><path d="M0 100h100" stroke="#aaa" stroke-width="50"/>'
            '<path d="M0 200h100" stroke="black" stroke-opacity="0.3" stroke-width="50"/>'
            '<rect x="-500" y="0" width="100" height="100" fill="black"/>'
        )
    )
    assert len(field.edges) == 4
    clutter = grey_at(field.floor, np.array([[-0.45, -0.05]]))
    assert clutter.tolist() == [0]


def test_what_is_not_shown_is_no_tape(drawing):
    hidden = "".join(
        f'<g {how}><path d="M0 100h100" {TAPE}/></g>'
        for how in ('display="none"', 'visibility="hidden"', 'style="display:none"')
    )
    field = drawing(page(f'<path d="M0 0h100" {TAPE}/>{hidden}<path d="M0 50h9" stroke="none"/>'))
    assert len(field.edges) == 4


def test_light_paint_over_tape_hides_it_in_picture_and_edges(drawing):
    gap = '<rect x="40" y="-50" width="20" height="100" fill="white"/>'
    tape = f'<path d="M0 0h100" {TAPE}/>'
    assert len(drawing(page(gap + tape)).edges) == 4
    field = drawing(page(tape + gap))
    assert [part.bounds[::2] for part in dark_area(field).geoms] == [(0, 0.04), (0.06, 0.1)]
    assert grey_at(field.floor, np.array([[0.05, 0.0]])).tolist() == [255]


def test_tape_ends_where_the_drawing_ends(drawing):
    field = drawing(page(f'<path d="M900 0h300" {TAPE}/>'))
    assert dark_area(field).bounds == pytest.approx((0.9, -0.025, 1.0, 0.025))


def test_the_width_is_that_of_most_tape(drawing):
    field = drawing(
        page(f'<path d="M0 0h300" {TAPE}/><path d="M0 100h100" stroke="#000" stroke-width="20"/>')
    )
    assert field.tape_width == pytest.approx(0.05)


@settings(
    deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25
)
@given(
    angle=st.floats(-360, 360), scale=st.floats(0.5, 2), x=st.floats(-200, 200),
    y=st.floats(-100, 100),
)  # fmt: skip
def test_picture_and_edges_agree_wherever_the_tape_lies(drawing, angle, scale, x, y):
    field = drawing(
        page(
            f'<g transform="translate({x:.6f} {y:.6f}) rotate({angle:.6f}) scale({scale:.6f})">'
            f'<path d="M-90 0 C 0 90 40-90 90 0" {TAPE}/></g>'
        )
    )
    edges = field.edges[lengths(field.edges) > 0.004]
    normals = np.stack([edges[:, 3] - edges[:, 1], edges[:, 0] - edges[:, 2]], axis=1)
    normals /= lengths(edges)[:, None]
    middles = (edges[:, :2] + edges[:, 2:]) / 2
    assert (grey_at(field.floor, middles + 0.002 * normals) == 255).all()
    assert (grey_at(field.floor, middles - 0.002 * normals) == 34).all()
    ink = (255.0 - field.floor.image).sum() / (255 - 34) * 1e-6
    assert ink == pytest.approx(dark_area(field).area, rel=1e-3)
