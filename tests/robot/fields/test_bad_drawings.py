"""Drawings that cannot be a field: each is refused in one clear line, and nothing grows."""

import re

import pytest
from hypothesis import strategies as st

from robot.fields.field import FieldError
from robot.fields.svg_field import load_svg

SVG = 'xmlns="http://www.w3.org/2000/svg"'
TAPE = 'stroke="#222" stroke-width="50" fill="none"'


@pytest.fixture
def drawing(tmp_path):
    """Loads a field from the content of an SVG file."""

    def load(content):
        path = tmp_path / "drawing.svg"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return load_svg(path)

    return load


def page(content, attributes=""):
    box = 'width="2000" height="1000" viewBox="-1000 -500 2000 1000"'
    return f"<svg {SVG} {box} {attributes}>{content}</svg>"


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "not well-formed XML"),
        ("hello", "not well-formed XML"),
        ("<svg>", "not well-formed XML"),
        ('<?xml version="1.0" encoding="klingon"?><svg/>', "not well-formed XML"),
        ("<html/>", "valid is an svg"),
        (f"<svg {SVG}/>", "no size"),
        (page(""), "no tape"),
        (page('<path d="M0 0h100" stroke="#999" stroke-width="50"/>'), "no tape"),
        (page(f'<path d="M5000 0h100" {TAPE}/>'), "no tape"),
        (page(f'<path d="M0 0h100" transform="scale(0)" {TAPE}/>'), "no tape"),
        (page('<path d="M0 0h100" stroke="#000" stroke-width="0.5"/>'), "valid is 1 to 1000"),
        (page('<path d="M0 0h100" stroke="#000" stroke-width="9000"/>'), "valid is up to 1000"),
        (page('<path d="M0 0h100" stroke="#000" stroke-width="-50"/>'), "stroke-width is '-50'"),
        (page('<path d="M0 0h100" stroke="#000" stroke-width="nan"/>'), "stroke-width is 'nan'"),
        (page('<path d="M0 0h100" stroke="#000" stroke-width="5em"/>'), "stroke-width is '5em'"),
        (page('<path d="M0 0h100" stroke="blakc" stroke-width="50"/>'), "stroke is 'blakc'"),
        (page('<path d="M0 0h100" stroke="url(#a)" stroke-width="50"/>'), "stroke is 'url"),
        (page(f'<path d="M0 0h100" fill-opacity="much" {TAPE}/>'), "fill-opacity is 'much'"),
        (page(f'<path d="M0 0h100" opacity="half" {TAPE}/>'), "opacity is 'half'; valid are a"),
        (page(f'<path d="M0 0h100" opacity="0.5" {TAPE}/>'), "no tape"),
        (page('<path d="M0 0h100" stroke="#000" stroke-width="0"/>'), "no tape"),
        (page(f'<path d="M0 0h100" marker-end="url(#a)" {TAPE}/>'), "marker-end"),
        (page(f'<path d="M0 0h100" stroke-linecap="pointed" {TAPE}/>'), "butt, round, square"),
        (page(f'<path d="M0 0h100" stroke-dasharray="-1" {TAPE}/>'), "stroke-dasharray"),
        (page(f'<path d="M0 0h100" stroke-dasharray="1e-9" {TAPE}/>'), "dashes"),
        (page(f'<g clip-path="url(#a)"><path d="M0 0h100" {TAPE}/></g>'), "clip-path"),
        (page(f'<path d="M0 0 L oops" {TAPE}/>'), "cannot be read"),
        (page(f'<path d="M200 abc" {TAPE}/>'), "cannot be read at 'abc'; valid are commands"),
        (page(f'<path d="M0 0h9" transform="translate(" {TAPE}/>'), "transform is 'translate('"),
        (page(f'<path d="M0 0 L 1e999 0" {TAPE}/>'), "too large or no number"),
        (page(f'<path d="M0 0 C 1e999 0 0 0 9 9" {TAPE}/>'), "too large or no number"),
        (page(f'<path d="M0 0h100" transform="scale(1e300)" {TAPE}/>'), "too large or no number"),
        (page(f'<path d="M0 0h1e8" {TAPE}/>'), "further out"),
        (page(f'<circle r="1e3" transform="scale(1e6)" {TAPE}/>'), "more than 20000 lines"),
        (page(f'<path d="M0 0{"h1v1" * 10_001}" {TAPE}/>'), "more than 20000 points"),
        (page(f'<path d="M0 0h1v1" transform="scale(1e5 1e-5)" {TAPE}/>'), "5e+06 mm wide"),
        (page('<text x="0" y="0">hello</text>'), "there is no tape"),
        (page('<image href="a.png"/>'), "'image' is not understood"),
        (page('<use href="#nothing"/>'), "the id of an element"),
        (page('<g id="a"><use href="#a"/></g>'), "nested"),
        (page("<g>" * 100 + "</g>" * 100), "nested"),
        (page("<g/>" * 10_001), "more than 10000 elements"),
        (page("<style>" + "a" * 70_000 + "</style>"), "style sheet"),
        (page(f'<path d="M0 0h100" {TAPE}/>', 'data-start="1 2"'), "data-start is '1 2'"),
        (page(f'<path d="M0 0h100" {TAPE}/>', 'data-start="nan 0 0"'), "data-start"),
        (page(f'<path d="M0 0h100" {TAPE}/>', 'data-start="9000 0 0"'), "not on the field"),
        (
            f'<svg {SVG} viewBox="0 0 900 900" data-start="500 300 90">'
            f'<path d="M0 9h99" {TAPE}/></svg>',
            "its y points up, and that of drawing programs down; was 500 -300 -90 meant?",
        ),
        (f'<svg {SVG} width="0" height="5"/>', "the drawing is 0 x 5 mm"),
        (f'<svg {SVG} width="1e9" height="500"/>', "valid is 10 to 100000"),
        (f'<svg {SVG} width="nan" height="500"/>', "width is 'nan'"),
        (f'<svg {SVG} width="500em" height="500em"/>', "width is '500em'"),
        (f'<svg {SVG} viewBox="0 0 nan 5"/>', "viewBox is '0 0 nan 5'"),
        (f'<svg {SVG} viewBox="0 0 1e999 5"/>', "viewBox is"),
        (f'<svg {SVG} viewBox="0 0 0 0"/>', "viewBox is"),
        (f'<svg {SVG} viewBox="0 0 -5 5"/>', "viewBox is"),
        (f'<svg {SVG} viewBox="0 0 9"/>', "viewBox is"),
    ],
)
def test_a_bad_drawing_is_refused_in_one_line_that_says_why(drawing, text, complaint):
    with pytest.raises(FieldError, match=re.escape(complaint)) as refusal:
        drawing(text)
    message = str(refusal.value)
    assert "\n" not in message
    assert len(message) < 400
    assert "drawing.svg: " in message


def test_an_absent_file_a_folder_and_a_huge_file_are_refused(tmp_path):
    with pytest.raises(FieldError, match="no such file"):
        load_svg(tmp_path / "absent.svg")
    with pytest.raises(FieldError, match="no such file"):
        load_svg(tmp_path)
    huge = tmp_path / "huge.svg"
    with huge.open("wb") as file:
        file.truncate(1 << 30)
    with pytest.raises(FieldError, match="1073741824 bytes"):
        load_svg(huge)


def test_entities_are_refused_before_they_grow(drawing):
    entities = '<!ENTITY e0 "aaaaaaaaaa">'
    for i in range(1, 12):
        grown = f"&e{i - 1};" * 10
        entities += f'<!ENTITY e{i} "{grown}">'
    with pytest.raises(FieldError, match="declares XML entities"):
        drawing(f"<!DOCTYPE svg [{entities}]>{page('<title>&e11;</title>')}")


def test_elements_that_use_each_other_are_refused_before_they_grow(drawing):
    levels = "".join(
        f'<g id="g{i}"><use href="#g{i - 1}"/><use href="#g{i - 1}"/></g>' for i in range(1, 30)
    )
    with pytest.raises(FieldError, match="more than 10000 elements"):
        drawing(page(f'<defs><g id="g0"/>{levels}</defs><use href="#g29"/>'))


def test_what_editors_leave_in_a_file_does_no_harm(drawing):
    doctype = '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://w3.org/svg11.dtd">'
    field = drawing(
        f'<?xml version="1.0" encoding="UTF-8"?>{doctype}<!-- comment -->'
        + page(
            '<defs><linearGradient id="a"><stop/></linearGradient></defs><metadata>x</metadata>'
            f'<e:view xmlns:e="http://e.org"><e:grid/></e:view><path d="M0 0h100" {TAPE}/>'
        )
    )
    assert len(field.edges) == 4


words = st.sampled_from(
    ["M", "0", "10", "-5", "1e9", "1e999", "nan", "C", "A", "Z", "h", "%", "mm", "none", "black",
     "(", ")", "rotate(", "scale(", "#12", "#123456", "url(#a)", "round", ",", " ", ";", ":", "é"]
)  # fmt: skip
values = st.lists(words, max_size=8).map(" ".join)
names = st.sampled_from(
    ["d", "x", "y", "r", "rx", "cx", "width", "height", "points", "transform", "style", "stroke",
     "stroke-width", "stroke-linejoin", "stroke-dasharray", "fill", "fill-rule", "viewBox", "id",
     "class", "href", "stroke-miterlimit", "stroke-opacity", "preserveAspectRatio", "color"]
)  # fmt: skip
tags = st.sampled_from(["path", "rect", "circle", "ellipse", "polygon", "polyline", "line", "use"])
elements = st.tuples(tags, st.dictionaries(names, values, max_size=6))
