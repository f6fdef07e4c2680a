"""Files as Inkscape writes them load as they are: layers, units, its own elements, and text."""

from __future__ import annotations

import math

import pytest

from robot.fields.drawing.question import LEFT_OUT
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2

SPACES = (
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
    'xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd" '
    'xmlns:xlink="http://www.w3.org/1999/xlink" xmlns="http://www.w3.org/2000/svg" '
    'xmlns:svg="http://www.w3.org/2000/svg" xmlns:dc="http://purl.org/dc/elements/1.1/" '
    'xmlns:cc="http://creativecommons.org/ns#" '
    'xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#"'
)
VIEW = (
    '<sodipodi:namedview id="namedview1" pagecolor="#ffffff" bordercolor="#000000" '
    'borderopacity="0.25" inkscape:showpageshadow="2" inkscape:pageopacity="0.0" '
    'inkscape:pagecheckerboard="0" inkscape:deskcolor="#d1d1d1" inkscape:document-units="{units}" '
    'showgrid="true" inkscape:zoom="0.35" inkscape:current-layer="layer1">'
    '<inkscape:grid type="xygrid" id="grid1" units="mm" spacingx="10" spacingy="10"/>'
    '<sodipodi:guide position="0,500" orientation="0,1" id="guide1" inkscape:locked="false"/>'
    '<inkscape:page x="0" y="0" width="1500" height="1000" id="page1" margin="0" bleed="0"/>'
    "</sodipodi:namedview>"
)
METADATA = (
    '<metadata id="metadata1"><rdf:RDF><cc:Work rdf:about=""><dc:format>image/svg+xml</dc:format>'
    '<dc:type rdf:resource="http://purl.org/dc/dcmitype/StillImage"/><dc:title>Feld</dc:title>'
    "</cc:Work></rdf:RDF></metadata>"
)
TEXT = (
    '<text xml:space="preserve" style="font-style:normal;font-size:42.3333px;line-height:1.25;'
    'font-family:sans-serif;fill:#000000;fill-opacity:1;stroke:none;stroke-width:0.264583" '
    'x="200" y="150" id="text1"><tspan sodipodi:role="line" id="tspan1" x="200" y="150" '
    'style="stroke-width:0.264583">1,20 m</tspan></text>'
)
STYLE = (
    "fill:none;stroke:#000000;stroke-width:{width};stroke-linecap:butt;stroke-linejoin:miter;"
    "stroke-miterlimit:4;stroke-dasharray:none;stroke-opacity:1;-inkscape-stroke:none;"
    "paint-order:normal"
)
PX = 96 / 25.4


def inkscape(size: str, content: str, units: str = "mm", root: str = "") -> str:
    return (
        '<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n'
        f"<!-- Created with Inkscape (http://www.inkscape.org/) -->\n\n<svg {size} "
        f'version="1.1" id="svg1" inkscape:version="1.3.2 (091e20e, 2023-11-25)" '
        f'sodipodi:docname="feld.svg" {root} {SPACES}>{VIEW.format(units=units)}{METADATA}'
        '<defs id="defs1"><inkscape:path-effect effect="fillet_chamfer" id="path-effect1" '
        f'is_visible="true" lpeversion="1"/></defs>{content}</svg>'
    )


def layer(content: str, more: str = "") -> str:
    return (
        f'<g inkscape:label="Ebene 1" inkscape:groupmode="layer" id="layer1" {more}>{content}</g>'
    )


def box(factor: float = 1.0) -> str:
    """A rectangle of tape, 1200 by 600 mm around (750, 500), in units of a factor."""
    x, y, width, height, tape = (value * factor for value in (150, 200, 1200, 600, 50))
    return (
        f'<rect style="{STYLE.format(width=f"{tape:.4f}")}" id="rect1" width="{width:.4f}" '
        f'height="{height:.4f}" x="{x:.4f}" y="{y:.4f}" ry="0" />'
    )


MM = 'width="1500mm" height="1000mm" viewBox="0 0 1500 1000"'
PLAIN = {
    "millimetres": inkscape(MM, layer(box())),
    "text": inkscape(MM, layer(box() + TEXT)),
    "a layer that was moved": inkscape(
        MM, layer(f'<g transform="translate(-30.5,12.25)">{box()}</g>',
                  'transform="translate(30.5,-12.25)"'),
    ),
    "a layer that was turned about": inkscape(
        MM, layer(box(), 'transform="matrix(-1,0,0,-1,1500,1000)"')
    ),
    "layers in layers, one hidden, one locked": inkscape(
        MM,
        layer(f'<g inkscape:groupmode="layer" id="layer2" sodipodi:insensitive="true">{box()}</g>')
        + '<g inkscape:groupmode="layer" id="layer3" style="display:none"><image x="0" y="0" '
        f'width="9" height="9" xlink:href="photo.jpg"/>{TEXT}<path d="M 0,0 H 900" '
        'style="stroke:#000000;stroke-width:50"/></g>',
    ),
    "a viewBox of other units": inkscape(
        'width="1500mm" height="1000mm" viewBox="0 0 396.875 264.58333"',
        layer(box(396.875 / 1500)),
    ),
    "pixels": inkscape(
        f'width="{1500 * PX:.5f}px" height="{1000 * PX:.5f}px" '
        f'viewBox="0 0 {1500 * PX:.5f} {1000 * PX:.5f}"', layer(box(PX)), "px"),
    "centimetres": inkscape(
        'width="150cm" height="100cm" viewBox="0 0 150 100"', layer(box(0.1)), "cm"
    ),
    "old, without a viewBox": inkscape('width="1500mm" height="1000mm"', layer(box(PX)), "px"),
    "a path with Inkscape's own attributes": inkscape(
        MM,
        layer(f'<path style="{STYLE.format(width=50)}" d="m 150,200 h 1200 v 600 h -1200 z" '
              'id="path1" sodipodi:nodetypes="ccccc" inkscape:path-effect="#path-effect1" '
              'inkscape:original-d="m 150,200 h 1200 v 600 h -1200 z" '
              'inkscape:connector-curvature="0"/>'),
    ),
    "the start, y up": inkscape(MM, layer(box()), root='data-start="750 -500 90"'),
}  # fmt: skip


@pytest.mark.parametrize("name", PLAIN)
def test_inkscapes_file_is_the_field_that_was_drawn(name: str) -> None:
    field = field_of_drawing(PLAIN[name], "feld")
    xmin, ymin, xmax, ymax = field.extent
    # The drawing's own (0, 0) is the map's origin: with Inkscape the page's upper left corner.
    assert (xmin, ymin, xmax, ymax) == pytest.approx((0, -1, 1.5, 0), abs=2e-4)
    assert field.tape[0].width == pytest.approx(0.05, abs=1e-5)
    corners = field.edges.reshape(-1, 2)
    assert corners.min(axis=0).tolist() == pytest.approx([0.125, -0.825], abs=2e-5)
    assert corners.max(axis=0).tolist() == pytest.approx([1.375, -0.175], abs=2e-5)
    assert (LEFT_OUT in field.notes) == (name == "text")
    if name.startswith("the start"):
        assert field.start == Pose2(0.75, -0.5, math.pi / 2)


def test_text_is_told_and_is_no_tape() -> None:
    field = field_of_drawing(PLAIN["text"], "feld")
    assert field.notes[LEFT_OUT].startswith("text in the drawing is no tape, and left out")
    plain = field_of_drawing(PLAIN["millimetres"], "feld")
    assert (field.floor.image == plain.floor.image).all()
    assert (field.edges == plain.edges).all()
