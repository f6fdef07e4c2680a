# ruff: noqa: E501 - lines are as long as the programs write them
"""Drawings of floors as the programs of other people write them, made here by their habits.

All are 420 mm x 300 mm, with tape of some 20 mm: small enough to be looked at pixel by pixel.
"""

from __future__ import annotations

SVG = 'xmlns="http://www.w3.org/2000/svg"'
XLINK = 'xmlns:xlink="http://www.w3.org/1999/xlink"'
HEAD = '<?xml version="1.0" encoding="UTF-8" standalone="no"?>\n'
DTD = (
    '<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
    '"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">\n'
)
PT, PX = 72 / 25.4, 96 / 25.4
INK = "fill:none;stroke:#000000;stroke-width:20"


def scaled(numbers: str, factor: float) -> str:
    """Multiply each number of a text of letters and numbers, as in a path."""
    parts = (
        part if part.isalpha() else f"{float(part) * factor:.4f}".rstrip("0").rstrip(".")
        for part in numbers.split()
    )
    return " ".join(parts)


CURVE = "M 60 220 C 60 120 180 120 210 180 C 240 240 340 240 360 90"
HOOK = "M 40 50 H 300 V 120 L 250 150"


def inkscape(content: str, root: str = "", units: str = "mm") -> str:
    return (
        f'{HEAD}<!-- Created with Inkscape (http://www.inkscape.org/) -->\n<svg width="420mm" '
        f'height="300mm" viewBox="0 0 420 300" version="1.1" id="svg5" {SVG} {XLINK} '
        'inkscape:version="1.2.2 (b0a8486541, 2022-12-01)" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        'xmlns:sodipodi="http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd" '
        f'xmlns:svg="http://www.w3.org/2000/svg" {root}>'
        '<sodipodi:namedview id="namedview7" pagecolor="#ffffff" bordercolor="#000000" '
        f'inkscape:document-units="{units}" showgrid="false"/>{content}</svg>'
    )


def illustrator(content: str, style: str, box: str = "") -> str:
    w, h = 420 * PT, 300 * PT
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n<!-- Generator: Adobe Illustrator 27.0.0, SVG '
        f'Export Plug-In . SVG Version: 6.00 Build 0)  -->\n<svg version="1.1" id="Ebene_1" {SVG} '
        f'{XLINK} x="0px" y="0px" width="420mm" height="300mm" '
        f'viewBox="{box or f"0 0 {w:.2f} {h:.2f}"}" style="enable-background:new 0 0 {w:.2f} '
        f'{h:.2f};" xml:space="preserve"><style type="text/css">\n{style}\n</style>{content}</svg>'
    )


def affinity(content: str, dpi: float = 96) -> str:
    w, h = 420 * dpi / 25.4, 300 * dpi / 25.4
    return (
        f'{HEAD}{DTD}<svg width="420mm" height="300mm" viewBox="0 0 {w:.0f} {h:.0f}" version="1.1" '
        f'{SVG} {XLINK} xml:space="preserve" xmlns:serif="http://www.serif.com/" style="fill-rule:'
        'evenodd;clip-rule:evenodd;stroke-linejoin:round;stroke-miterlimit:2;">'
        f"{content}</svg>"
    )


def libreoffice(content: str, clip: str = "0 0 42000 30000") -> str:
    x, y, w, h = clip.split()
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n{DTD}<svg version="1.2" width="420mm" '
        'height="300mm" viewBox="0 0 42000 30000" preserveAspectRatio="xMidYMid" '
        f'fill-rule="evenodd" stroke-width="28.222" stroke-linejoin="round" {SVG} '
        f'xmlns:ooo="http://xml.openoffice.org/svg/export" {XLINK} xml:space="preserve">'
        '<defs class="ClipPathGroup"><clipPath id="presentation_clip_path" '
        f'clipPathUnits="userSpaceOnUse"><rect x="{x}" y="{y}" width="{w}" height="{h}"/>'
        '</clipPath></defs><defs class="TextShapeIndex"><g ooo:slide="id1" ooo:id-list="id3"/>'
        '</defs><defs class="EmbeddedBulletChars"><g id="bullet-char-template-57356" '
        'transform="scale(0.00048828125,-0.00048828125)"><path d="M 580,1141 L 1163,571 580,0 '
        '-4,571 580,1141 Z"/></g></defs><g class="SlideGroup"><g><g id="container-id1"><g id="id1" '
        'class="Slide" clip-path="url(#presentation_clip_path)"><g class="Page">'
        f"{content}</g></g></g></g></g></svg>"
    )


def plain(content: str, root: str = 'width="420mm" height="300mm" viewBox="0 0 420 300"') -> str:
    return f"<svg {SVG} {XLINK} {root}>{content}</svg>"


OFFICE: dict[str, str] = {
    # --- Inkscape
    "inkscape, layers": inkscape(
        '<g inkscape:label="Ebene 1" inkscape:groupmode="layer" id="layer1" style="display:inline">'
        f'<path style="{INK};stroke-linecap:butt;stroke-opacity:1;-inkscape-stroke:none" '
        f'd="{CURVE}" id="path1" sodipodi:nodetypes="ccc"/></g><g inkscape:groupmode="layer" '
        'id="layer2" style="display:none" sodipodi:insensitive="true"><image width="420" '
        'height="300" xlink:href="photo.jpg"/><text x="9" y="9">1,40 m</text></g>'
    ),
    "inkscape, layer moved": inkscape(
        f'<g transform="translate(-12.5,8.25)" style="{INK}"><rect width="300" height="180" '
        'x="80" y="50" ry="40"/><g transform="matrix(0.9,0.1,-0.1,0.9,20,30)"><circle r="40" '
        'cx="210" cy="120" style="stroke-linejoin:round;paint-order:stroke fill markers"/></g></g>'
    ),
    "inkscape, arcs": inkscape(
        f'<path sodipodi:type="arc" style="{INK}" sodipodi:cx="210" sodipodi:rx="120" '
        'd="M 330,150 A 120,90 0 0 1 226.7,239.1 120,90 0 0 1 92.6,168.7" id="a"/>'
        f'<path style="{INK};stroke-linecap:round" d="m 120,60 a 60,30 30 1 0 10,-5"/>'
    ),
    "inkscape, clones": inkscape(
        f'<defs id="defs2"/><path id="p" style="{INK}" d="M 40,40 H 140 V 100"/><use x="0" y="0" '
        'xlink:href="#p" transform="translate(150,40)" id="use1"/><use xlink:href="#use1" '
        'transform="rotate(30,200,150)" width="100%" height="100%"/>'
    ),
    "inkscape, swatches": inkscape(
        '<defs><linearGradient id="lg1" inkscape:swatch="solid"><stop style="stop-color:#101010;'
        'stop-opacity:1;" offset="0" id="stop1"/></linearGradient><linearGradient '
        'inkscape:collect="always" xlink:href="#lg1" id="lg2"/></defs><path style="fill:none;'
        f'stroke:url(#lg2);stroke-width:20" d="{HOOK}"/>'
    ),
    "inkscape, clipped": inkscape(
        '<defs><clipPath clipPathUnits="userSpaceOnUse" id="clip1"><path d="M 100,40 H 330 V 200 '
        'L 200,260 Z" style="fill:none;stroke:#ff0000"/></clipPath></defs><g '
        f'clip-path="url(#clip1)" transform="rotate(5)"><path style="{INK}" d="{CURVE}"/></g>'
        f'<path style="{INK}" d="M 20,280 H 400"/>'
    ),
    "inkscape, translucent": inkscape(
        '<rect style="fill:#d7d5cf" width="420" height="300"/><g style="opacity:0.5"><rect '
        'style="fill:#aa0000;opacity:0.6" width="90" height="60" x="250" y="40"/></g>'
        f'<g opacity="0.8"><path style="{INK}" d="{HOOK}"/><path style="{INK}" d="M 60,20 V 250"/>'
        "</g>"
    ),
    "inkscape, dashes": inkscape(
        f'<path style="{INK};stroke-dasharray:40, 20;stroke-dashoffset:10" d="{CURVE}"/>'
        f'<path style="{INK};stroke-dasharray:none;stroke-miterlimit:4" d="M 30,30 H 390 L 300,60"/>'
    ),
    "inkscape, old, without a viewBox": (
        f'{HEAD}<svg {SVG} xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        'width="420mm" height="300mm" id="svg2" version="1.1" inkscape:version="0.92"><g '
        'inkscape:groupmode="layer" id="layer1" transform="translate(0,81.5)"><path style="fill:'
        f'none;stroke:#000000;stroke-width:{20 * PX:.6f};stroke-linecap:butt" '
        f'd="{scaled(CURVE, PX)}"/></g></svg>'
    ),
    "inkscape, px": inkscape(f'<path style="{INK}px" d="{HOOK}"/>', units="px").replace(
        'width="420mm" height="300mm"', f'width="{420 * PX}" height="{300 * PX}px"'
    ),
    "inkscape, styles of the document": inkscape(
        '<style id="style1">\n#layer1 > path { fill:none; stroke:#111; stroke-width:20 }\n'
        'g[inkscape\\:label="off"] { display:none }\n#off path{display:none}</style>'
        f'<g id="layer1"><path d="{HOOK}"/></g><g id="off" style="{INK}"><path d="{CURVE}"/></g>'
    ),
    # --- Illustrator
    "illustrator, classes": illustrator(
        f'<rect x="99.2" y="99.2" class="st0" width="850.4" height="481.9"/><path class="st0 st1" '
        f'd="{scaled(CURVE, PT)}"/>',
        "\t.st0{fill:none;stroke:#000000;stroke-width:56.6929;stroke-miterlimit:10;}\n"
        "\t.st1{stroke:#231F20;stroke-linecap:round;stroke-linejoin:round;}",
    ),
    "illustrator, order of the sheet": illustrator(
        f'<path class="cls-2 cls-1" d="{scaled(HOOK, PT)}"/><path class="cls-1 cls-2" '
        f'd="{scaled(CURVE, PT)}"/>',
        ".cls-1, .cls-2 { fill: none; stroke: #000; } .cls-1 { stroke-width: 70px; } "
        ".cls-2 { stroke-width: 52px; stroke-miterlimit: 10; }",
    ),
    "illustrator, artboard": illustrator(
        '<g id="Artboard_1"><defs><rect id="SVGID_1_" x="60" y="60" width="900" height="700"/>'
        '</defs><clipPath id="SVGID_00000_"><use xlink:href="#SVGID_1_" style="overflow:visible;"/>'
        '</clipPath><g style="clip-path:url(#SVGID_00000_);"><path class="st0" '
        f'd="{scaled(CURVE, PT)}"/><line class="st0" x1="0" y1="400" x2="1200" y2="300"/></g></g>',
        ".st0{fill:none;stroke:#000000;stroke-width:60;}",
    ),
    "illustrator, switch": (
        '<?xml version="1.0" encoding="utf-8"?><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
        '"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [\n<!ENTITY ns_ai '
        '"http://ns.adobe.com/AdobeIllustrator/10.0/">\n<!ENTITY ns_svg '
        '"http://www.w3.org/2000/svg">\n<!ENTITY st0 "fill:none;stroke:#000000;stroke-width:20;">'
        '\n]>\n<svg version="1.1" xmlns="&ns_svg;" xmlns:i="&ns_ai;" width="420mm" height="300mm" '
        'viewBox="0 0 420 300" xml:space="preserve"><switch><foreignObject '
        'requiredExtensions="&ns_ai;" x="0" y="0" width="1" height="1"><i:pgfRef/></foreignObject>'
        f'<g i:extraneous="self"><path style="&st0;" d="{CURVE}"/></g></switch></svg>'
    ),
    "illustrator, symbols": illustrator(
        '<symbol id="Mark" viewBox="-40 -40 80 80"><circle class="st0" r="30"/></symbol>'
        '<use xlink:href="#Mark" width="80" height="80" x="-40" y="-40" transform="matrix(3 0 0 -3 '
        '300 300)" style="overflow:visible;"/><use xlink:href="#Mark" x="700" y="300" width="300" '
        'height="240"/><symbol id="never"><rect width="900" height="900"/></symbol>',
        ".st0{fill:none;stroke:#000000;stroke-width:20;}",
    ),
    "illustrator, media": illustrator(
        f'<path class="a" d="{scaled(HOOK, PT)}"/><path class="a b" d="{scaled(CURVE, PT)}"/>',
        "@import url('https://fonts.example/css?family=Roboto');@font-face{font-family:x;src:"
        "url(x.woff)}@media screen{.a{fill:none;stroke:#000;stroke-width:60}}"
        "@media print{.a{stroke-width:5}.b{display:inline !important}}.b{display:none}",
    ),
    "illustrator, descendants": illustrator(
        f'<g id="planA"><path class="t" d="{scaled(CURVE, PT)}"/></g><g id="planB"><path class="t" '
        f'd="{scaled(HOOK, PT)}"/></g><a xlink:href="https://example.com"><g class="t x"><path '
        'd="M 60 750 h 900"/></g></a>',
        ".t{fill:none;stroke:#000;stroke-width:60}#planB .t{display:none}"
        "a > .t.x path:not(.y):first-child{stroke-width:40}",
    ),
    "illustrator, attributes": illustrator(
        f'<path data-name="tape one" d="{scaled(CURVE, PT)}"/><path data-name="guide" '
        f'd="{scaled(HOOK, PT)}"/><path id="last" d="M 60 60 V 700"/>',
        'path[data-name^="tape"], path#last{fill:none;stroke:#000;stroke-width:60}'
        '[data-name="guide"]{visibility:hidden}path:nth-of-type(3){stroke-width:30}',
    ),
    # --- Affinity
    "affinity, matrices": affinity(
        '<g transform="matrix(1,0,0,1,-40,-20)"><g id="Tape" transform="matrix(1.2,0,0,1.2,50,40)">'
        f'<path d="{scaled(CURVE, 3)}" style="fill:none;stroke:black;stroke-width:62.5px;'
        'stroke-linecap:round;stroke-miterlimit:1.5;"/></g></g>'
    ),
    "affinity, artboard": affinity(
        '<g id="Artboard1" serif:id="Artboard 1"><clipPath id="_clip1"><rect x="100" y="100" '
        'width="1300" height="900"/></clipPath><g clip-path="url(#_clip1)"><path '
        f'd="{scaled(CURVE, PX)}" style="fill:none;fill-rule:nonzero;stroke:rgb(35,31,32);'
        'stroke-width:75.59px;"/><rect x="0" y="500" width="1600" height="80" '
        'style="fill:rgb(190,200,180);"/></g></g>'
    ),
    "affinity, 300 dpi": affinity(
        f'<g transform="matrix(4.16667,0,0,4.16667,0,0)"><path d="{scaled(HOOK, 2.8346)}" '
        'style="fill:none;stroke:black;stroke-width:56.69px;stroke-linejoin:miter;'
        'stroke-miterlimit:10;"/></g>',
        300,
    ),
    "affinity, nested svg": affinity(
        '<svg x="200" y="150" width="1000" height="700" viewBox="0 0 100 100" '
        'preserveAspectRatio="xMaxYMin meet"><circle cx="50" cy="50" r="45" style="fill:none;'
        'stroke:black;stroke-width:11;"/><path d="M -20 50 H 90" style="stroke:black;'
        'stroke-width:11"/></svg>'
    ),
    "affinity, holes": affinity(
        '<rect x="0" y="0" width="1588" height="1134" style="fill:rgb(215,213,207);"/><path '
        'd="M300,300L900,300L900,800L300,800L300,300ZM450,450L450,650L750,650L750,450L450,450Z" '
        f'style="fill:rgb(30,30,30);"/><path d="{scaled(HOOK, PX)}" style="fill:none;stroke:black;'
        'stroke-width:75.59px;"/>'
    ),
    # --- LibreOffice
    "libreoffice, clip of the page": libreoffice(
        '<g class="com.sun.star.drawing.CustomShape"><g id="id3"><rect class="BoundingBox" '
        'stroke="none" fill="none" x="5000" y="5000" width="30000" height="20000"/><path '
        'fill="none" stroke="rgb(0,0,0)" stroke-width="2000" stroke-linejoin="miter" '
        'd="M 20000,24000 L 6000,24000 6000,6000 34000,6000 34000,24000 20000,24000 Z"/></g></g>'
    ),
    "libreoffice, clip that cuts": libreoffice(
        '<g class="com.sun.star.drawing.LineShape"><path fill="none" stroke="rgb(0,0,0)" '
        f'stroke-width="2000" stroke-linejoin="round" d="{scaled(CURVE, 100)}"/></g>',
        "9000 4000 20000 26000",
    ),
    "libreoffice, dashes as pieces": libreoffice(
        '<g><path fill="none" stroke="rgb(52,101,164)" stroke-width="2000" d="M 3000,9000 L '
        '9000,9000 M 12000,9000 L 18000,9000 M 21000,9000 L 27000,9000"/><path fill="rgb(114,159,'
        '207)" stroke="none" d="M 20000,20000 L 12000,20000 12000,15000 28000,15000 28000,20000 '
        '20000,20000 Z"/><path stroke="rgb(0,0,0)" stroke-width="2000" d="M 3000,25000 '
        'C 9000,22000 30000,28000 39000,25000" fill="none"/></g>'
    ),
}
