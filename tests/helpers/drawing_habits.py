# ruff: noqa: E501 - lines are as long as the programs write them
"""Drawings of floors as CAD, converters and people's own hands write them, made here.

They are as large as those of ``drawing_programs``.
"""

from __future__ import annotations

import math
from itertools import pairwise

from drawing_programs import CURVE, DTD, HEAD, HOOK, OFFICE, PT, SVG, XLINK, plain, scaled

TAPE = 'fill="none" stroke="#222" stroke-width="20"'


def short_lines(count: int, factor: float = 1.0) -> str:
    """A circle as DXF converters cut it: lines that nobody joins."""
    places = [
        (factor * (210 + 110 * math.cos(t)), factor * (150 + 110 * math.sin(t)))
        for t in (2 * math.pi * k / count for k in range(count + 1))
    ]
    return "".join(
        f'<line x1="{a[0]:.3f}" y1="{a[1]:.3f}" x2="{b[0]:.3f}" y2="{b[1]:.3f}"/>'
        for a, b in pairwise(places)
    )


OTHERS: dict[str, str] = {
    # --- CAD and converters
    "cad, short lines": plain(
        f'<g fill="none" stroke="black" stroke-width="20">{short_lines(400)}</g>'
    ),
    "cad, few short lines": plain(
        f'<g fill="none" stroke="black" stroke-width="20">{short_lines(60)}</g>'
    ),
    "dxf, y points up": plain(
        '<g transform="translate(0,300) scale(1,-1)" fill="none" stroke="black" '
        f'stroke-width="20"><path d="{CURVE}"/><polyline points="20,20 400,20 400,60"/></g>'
    ),
    "ezdxf": plain(
        "<defs><style>.C1 {stroke: #000000; stroke-width: 47619; fill: none; }\n.C2 {stroke: "
        '#7f7f7f; stroke-width: 9000; fill: none; }</style></defs><rect fill="#ffffff" x="0" y="0" '
        'width="1000000" height="714286" fill-opacity="1.0"/><g stroke-linecap="round" '
        'stroke-linejoin="round" fill-rule="evenodd"><path d="M 142857 142857 l 500000 0 l 0 300000" '
        'class="C1"/><path d="M 100000 600000 l 800000 0" class="C2"/></g>',
        'width="420mm" height="300mm" viewBox="0 0 1000000 714286" version="1.1"',
    ),
    "freecad": plain(
        '<g id="Sketch" transform="rotate(0.0,0.0,300.0) translate(0.0,300.0) scale(1,-1)">\n'
        '<path id="Sketch_w0000"  d="M 50.0 50.0 L 350.0 50.0 L 350.0 200.0 A 60 60 0 0 1 230 200" '
        'stroke="#191919" stroke-width="20 px" style="stroke-width:20.0;stroke-miterlimit:4;'
        'stroke-dasharray:none;stroke-linecap:square;fill:none;fill-opacity:1.0;fill-rule: evenodd"'
        "/>\n<title>b'Sketch'</title>\n</g>"
    ),
    "librecad": plain(
        '<g lc:layername="0" lc:is_locked="false" lc:is_printable="true" style="fill:none;stroke:'
        'black;stroke-width:20"><line x1="30" y1="40" x2="390" y2="40"/><path d="M340,150 A100,100 '
        '0 0,0 140,150 "/><circle cx="240" cy="210" r="30"/></g>',
        'xmlns:lc="https://librecad.org" width="420mm" height="300mm" viewBox="0 0 420 300"',
    ),
    "openscad": plain(
        '<title>OpenSCAD Model</title>\n<path d="\nM 60,-40 L 360,-40 L 360,-260 L 60,-260 z\n'
        'M 100,-80 L 100,-220 L 320,-220 L 320,-80 z\n" stroke="black" fill="lightgray" '
        'stroke-width="20"/>',
        'width="420mm" height="300mm" viewBox="0 -300 420 300" version="1.1"',
    ),
    "cadquery": plain(
        '<g transform="scale(2, -2)   translate(105,-75)" stroke-width="10" fill="none"><!-- solid '
        '--><g  stroke="rgb(0, 0, 0)" fill="none"><path d="M-80.0,-40.0 L80.0,-40.0 " />\n<path '
        'd="M80,-40 L80,40 "/>\n<path d="M80.0,40.0 A 80 80 0 0 1 -80,40"/></g></g>'
    ),
    "qcad": plain(
        f'<g style="fill:none;"><path d="{CURVE}" style="stroke:#000000;stroke-width:20;"/></g>'
        '<path d="M30,30 L390,30" style="stroke:#000000;stroke-width:0.79375cm;"/>'
    ),
    "hairline that does not scale": plain(
        '<g transform="scale(10 5)"><path d="M 4 10 L 38 10 L 38 50" fill="none" stroke="black" '
        'stroke-width="80" vector-effect="non-scaling-stroke"/><circle cx="16" cy="36" r="7" '
        'style="fill:none;stroke:#222;stroke-width:60px;vector-effect:non-scaling-stroke"/></g>'
    ),
    "pdf2svg and cairo": (
        f'{HEAD}<svg {SVG} {XLINK} width="{420 * PT:.4f}pt" height="{300 * PT:.4f}pt" '
        f'viewBox="0 0 {420 * PT:.4f} {300 * PT:.4f}" version="1.2"><defs><clipPath id="clip1">'
        '<path d="M 0 0 L 1190 0 L 1190 700 L 0 700 Z"/></clipPath></defs><g id="surface1"><g '
        'clip-path="url(#clip1)" clip-rule="nonzero"><path style="fill:none;stroke-width:566.93;'
        "stroke-linecap:butt;stroke-linejoin:miter;stroke:rgb(0%,0%,0%);stroke-opacity:1;"
        f'stroke-miterlimit:10;" d="{scaled(CURVE, 28.346)}" transform="matrix(0.1,0,0,-0.1,0,'
        f'{300 * PT:.3f})"/></g></g></svg>'
    ),
    "matplotlib": (
        f'{HEAD}{DTD}<svg {XLINK} width="{420 * PT:.4f}pt" height="{300 * PT:.4f}pt" '
        f'viewBox="0 0 {420 * PT:.4f} {300 * PT:.4f}" {SVG} version="1.1"><metadata/><defs><style '
        'type="text/css">*{stroke-linejoin: round; stroke-linecap: butt}</style></defs><g '
        'id="figure_1"><g id="patch_1"><path d="M 0 850.4 L 1190.55 850.4 L 1190.55 0 L 0 0 z" '
        f'style="fill: #ffffff"/></g><g id="line2d_1"><path d="{scaled(HOOK, PT)}" '
        'clip-path="url(#p1)" style="fill: none; stroke: #000000; stroke-width: 56.7; '
        'stroke-linecap: square"/></g></g><defs><clipPath id="p1"><rect x="150" y="50" width="900" '
        'height="600"/></clipPath></defs></svg>'
    ),
    "visio": plain(
        '<style type="text/css"><![CDATA[\n.st1 {fill:none;stroke:#000000;stroke-linecap:round;'
        "stroke-linejoin:round;stroke-width:56.7}\n.st2 {visibility:hidden}\n]]></style><g "
        'v:mID="0" v:index="1"><title>Page-1</title><g id="shape1-1" v:mID="1" '
        f'transform="translate(20,-30)"><path d="{scaled(CURVE, PT)}" class="st1"/></g><g '
        'class="st2"><path class="st1" d="M 0 0 L 900 800"/></g></g>',
        f'xmlns:v="http://schemas.microsoft.com/visio/2003/SVGExtensions/" width="{420 / 25.4:.5f}in" '
        f'height="{300 / 25.4:.5f}in" viewBox="0 0 {420 * PT:.3f} {300 * PT:.3f}" class="st5"',
    ),
    "corel": plain(
        '<defs><style type="text/css"><![CDATA[.str0 {stroke:#2B2A29;stroke-width:20;'
        "stroke-miterlimit:2.61313} .fil0 {fill:none;fill-rule:nonzero}]]></style></defs><g "
        f'id="Ebene_x0020_1"><path class="fil0 str0" d="{HOOK}"/><polygon class="fil0 str0" '
        'points="90,160 200,180 120,260 "/></g>',
        'xml:space="preserve" width="420mm" height="300mm" version="1.1" style="shape-rendering:'
        "geometricPrecision; text-rendering:geometricPrecision; fill-rule:evenodd; clip-rule:"
        'evenodd" viewBox="0 0 420 300"',
    ),
    "figma": plain(
        '<g clip-path="url(#clip0_1_2)"><rect width="420" height="300" fill="white"/><path '
        f'd="{HOOK}" stroke="black" style="stroke:black;stroke-opacity:1;" stroke-width="20"/>'
        '<circle cx="120" cy="210" r="50" fill="#D9D9D9" style="fill:#D9D9D9;fill:color(display-p3 '
        '0.8510 0.8510 0.8510);fill-opacity:1;"/></g><defs><clipPath id="clip0_1_2"><rect '
        'width="420" height="300" fill="white" style="fill:white;fill-opacity:1;"/></clipPath></defs>',
        'width="420mm" height="300mm" viewBox="0 0 420 300" fill="none"',
    ),
    "draw.io": plain(
        f'<defs/><g><g data-cell-id="0"><path d="{HOOK}" fill="none" stroke="#000000" '
        'stroke-width="20" stroke-miterlimit="10" pointer-events="stroke" style="stroke: '
        'light-dark(#000000, #ffffff);"/></g></g>',
        'width="420mm" height="300mm" viewBox="0 0 420 300" style="background-color: rgb(240, 240, '
        '240);" content="&lt;mxfile&gt;"',
    ),
    "potrace": (
        f'{HEAD}<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 20010904//EN" '
        f'"http://www.w3.org/TR/2001/REC-SVG-20010904/DTD/svg10.dtd"><svg version="1.0" {SVG} '
        f'width="{420 * PT:.2f}pt" height="{300 * PT:.2f}pt" viewBox="0 0 {420 * PT:.2f} '
        f'{300 * PT:.2f}" preserveAspectRatio="xMidYMid meet"><metadata>Created by potrace 1.16'
        f'</metadata><g transform="translate(0,{300 * PT:.2f}) scale(0.1,-0.1)" fill="#888888" '
        'stroke="none"><path d="M3000 4000 c300 -1200 1800 -1500 2600 -400 700 900 -200 2400 -1300 '
        "2300 -900 -80 -1500 -900 -1300 -1900z m900 300 c0 300 300 500 500 300 200 -300 -100 -700 "
        '-300 -600z"/><path d="M500 700 l9000 0" stroke="#000" stroke-width="560"/></g></svg>'
    ),
    "svgo": plain(
        '<path fill="none" stroke="#000" stroke-width="20" d="M30 40h120v60l40-20 40.5.5.5 40.5c10-'
        "40 60-40 70 0s60 40 70 0q10-30 20 0t20 0M60 200a40 25 0 1160 20 40 25 0 01-60-20zm90.5-.5"
        'l1e1-1.5E1 30 40z"/>'
    ),
    "css variables": plain(
        "<style>:root{--ink:#1a1a1a;--w:20}.t{fill:none;stroke:var(--ink);stroke-width:var(--w,5)}"
        ".u{stroke:var(--none, #333)}</style>"
        f'<path class="t" d="{HOOK}"/><path class="t u" d="M 60 200 H 380"/>'
    ),
    "important": plain(
        "<style>path{stroke:#000!important;fill:none;stroke-width:20}#a{stroke:#fff}"
        "svg>g+path~path{stroke-width:30}</style><g/>"
        f'<path id="a" style="stroke:#eee" d="{HOOK}"/><path d="M 60 200 H 380"/><path '
        'd="M 60 250 H 380"/>'
    ),
    "current colour": plain(
        '<g color="#181818" stroke="currentColor" fill="none" stroke-width="20"><path '
        f'd="{HOOK}"/><g color="#404040"><path d="M 60 200 H 380"/><path stroke="inherit" '
        'd="M 60 250 H 380" style="color:black"/></g></g>'
    ),
    "percentages": plain(
        '<rect x="10%" y="10%" width="50%" height="40%" fill="none" stroke="#111" stroke-width="5%"'
        '/><line x1="70%" y1="20%" x2="95%" y2="80%" stroke="black" stroke-width="6%"/>'
        '<ellipse cx="30%" cy="75%" rx="20%" ry="12%" fill="#999"/>'
    ),
    "uses with styles": plain(
        '<defs><path id="p" d="M 0 0 h 100 v 50"/><g id="g"><use href="#p"/><use href="#p" '
        f'transform="scale(1 -1)"/></g></defs><g {TAPE}><use href="#g" x="40" y="90"/><use '
        'href="#g" transform="translate(220 90) rotate(15)"/></g><use href="#p" x="200" y="200" '
        'style="fill:none;stroke:#444;stroke-width:16px"/>'
    ),
    "symbols with viewBoxes": plain(
        '<symbol id="s" viewBox="0 0 100 50" preserveAspectRatio="none"><path d="M 0 25 H 100 M 50 '
        f'0 V 50" {TAPE}/></symbol><use href="#s" x="30" y="30" width="160" height="200"/>'
        '<use href="#s" x="220" y="60" width="180" height="60"/>'
    ),
    "clip of a clip": plain(
        '<clipPath id="a"><circle cx="150" cy="150" r="110"/></clipPath><clipPath id="b" '
        'clip-path="url(#a)"><rect x="60" y="60" width="200" height="120"/><path d="M 240 160 h 100 '
        'v 100 h -100 z M 260 180 v 40 h 40 v -40 z" clip-rule="evenodd"/></clipPath>'
        f'<path d="M 20 60 L 400 240 M 20 240 L 400 60 M 150 0 V 300" clip-path="url(#b)" {TAPE}/>'
        f'<path d="M 380 10 V 290" {TAPE}/>'
    ),
    "clip of the box": plain(
        '<clipPath id="a" clipPathUnits="objectBoundingBox"><circle cx=".5" cy=".5" r=".45"/>'
        f'</clipPath><g clip-path="url(#a)" transform="translate(10 20)"><path d="{CURVE}" {TAPE}/>'
        f'<rect x="60" y="60" width="200" height="30" fill="#aaa"/></g><path d="M 20 20 H 400" '
        f"{TAPE}/>"
    ),
    "paint order": plain(
        '<rect x="60" y="60" width="150" height="150" fill="#ccc" stroke="#000" stroke-width="40" '
        'paint-order="stroke"/><rect x="260" y="60" width="100" height="150" fill="#ccc" '
        'stroke="#000" stroke-width="40"/>'
    ),
    "fill rules": plain(
        '<path d="M 100 30 L 150 200 L 20 90 H 180 L 50 200 Z" fill="#999"/><path d="M 300 30 L '
        '350 200 L 220 90 H 380 L 250 200 Z" fill="#999" fill-rule="evenodd"/>'
        f'<path d="M 20 250 H 400" {TAPE}/>'
    ),
    "joins and caps": plain(
        '<g fill="none" stroke="#000" stroke-width="24"><path d="M 30 100 L 70 30 L 110 100" '
        'stroke-linejoin="round" stroke-linecap="round"/><path d="M 150 100 L 190 30 L 230 100" '
        'stroke-linejoin="bevel" stroke-linecap="square"/><path d="M 270 100 L 290 30 L 310 100"/>'
        '<path d="M 350 100 L 370 30 L 390 100" stroke-miterlimit="9"/><path d="M 60 200 h 0" '
        'stroke-linecap="round"/><path d="M 120 200 z" stroke-linecap="square"/><path '
        'd="M 180 200 h 80 v 60 h -80 z M 300 200 h 60 v 60"/></g>'
    ),
    "skewed": plain(
        f'<g transform="translate(40,10) skewX(20) scale(.8,1.1)"><path d="{CURVE}" {TAPE}/></g>'
        f'<path d="{HOOK}" {TAPE} style="transform:translate(60px,40px) rotate(0.05turn)"/>'
    ),
    "transform origin": plain(
        f'<path d="M 60 80 h 120" {TAPE} style="transform:rotate(40deg);transform-origin:120px 80px"'
        f'/><path d="M 250 80 h 120" {TAPE} transform="rotate(90)" transform-origin="center"/>'
    ),
    "stroke of a stretched shape": plain(
        '<g transform="scale(3 1)"><circle cx="70" cy="150" r="50" fill="none" stroke="#000" '
        'stroke-width="14" stroke-dasharray="30 12"/></g>'
    ),
    "sheet for print, and a switch": plain(
        f'<style media="print">path{{display:none}}</style><style type="text/plain">x</style><switch>'
        f'<g requiredExtensions=""><path d="{CURVE}" {TAPE}/></g><g systemLanguage="x-other"/><g>'
        f'<path d="{HOOK}" {TAPE}/></g><g><rect width="300" height="300"/></g></switch>'
    ),
    "hidden by each way": plain(
        f'<path d="{HOOK}" {TAPE}/><g display="none"><text>9</text></g><g visibility="hidden"><path '
        f'd="M 0 200 H 400" {TAPE}/><path visibility="visible" d="M 60 250 H 380" {TAPE}/><image '
        'href="x.png" width="9" height="9"/></g><g opacity="0"><text>9</text></g><rect width="0" '
        'height="50"/><circle r="0" cx="50" cy="50"/><defs><rect width="400" height="400"/></defs>'
        '<text> </text><marker id="m"><rect width="90" height="90"/></marker>'
    ),
    "prefixed": (
        f'{HEAD}<svg:svg xmlns:svg="http://www.w3.org/2000/svg" width="420mm" height="300mm" '
        f'viewBox="0 0 420 300"><svg:path d="{HOOK}" fill="none" stroke="black" '
        'stroke-width="20"/></svg:svg>'
    ),
    "sides of other proportions": plain(
        f'<path d="{HOOK}" {TAPE}/>',
        'width="42cm" height="30cm" viewBox="-20 -10 500 300" preserveAspectRatio="xMinYMax slice"',
    ),
    "light tape on a dark floor": plain(
        f'<rect width="420" height="300" fill="#2a2a2c"/><g fill="none"><path stroke="#fff" '
        f'stroke-width="20" d="{CURVE}"/><path stroke="#ffd020" stroke-width="16" '
        'stroke-dasharray="40 20" d="M 30 30 H 390"/></g>'
    ),
}

DRAWINGS = OFFICE | OTHERS
