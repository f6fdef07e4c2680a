"""Writes a page as SVG or PDF, in millimetres; a printer at 100 % prints it at its true size."""

from __future__ import annotations

from collections.abc import Sequence
from xml.sax.saxutils import escape

from robot.calibration.lens.board_page import FilledPolygon, PrintedPage

POINTS = 72 / 25.4
"""A PDF's points in a millimetre."""


def svg(page: PrintedPage) -> str:
    """Return the page as SVG."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{page.width:g}mm" '
        f'height="{page.height:g}mm" viewBox="0 0 {page.width:g} {page.height:g}">',
        f'<rect width="{page.width:g}" height="{page.height:g}" fill="white"/>',
    ]
    for shape in page.shapes:
        points = " ".join(f"{x:.4f},{y:.4f}" for x, y in shape.points.tolist())
        colour = "black" if shape.black else "white"
        lines.append(f'<polygon points="{points}" fill="{colour}"/>')
    for text in page.texts:
        lines.append(
            f'<text x="{text.x:.3f}" y="{text.y:.3f}" font-size="{text.size:g}" '
            f'font-family="Helvetica, Arial, sans-serif">{escape(text.words)}</text>'
        )
    return "\n".join([*lines, "</svg>"]) + "\n"


def pdf(page: PrintedPage) -> bytes:
    """Return the page as PDF: filled polygons, and text."""
    content = "\n".join([*_painted(page), *_written(page)])
    return pdf_document([(page.width, page.height, content)])


def pdf_document(pages: Sequence[tuple[float, float, str]]) -> bytes:
    """Return a PDF 1.4 of pages: width and height [mm], and operators that paint it, in points.

    The font ``/F`` is Helvetica, which every reader has, with the characters of Latin-1.
    """
    kids = " ".join(f"{4 + 2 * number} 0 R" for number in range(len(pages)))
    objects = [
        # Readers then offer to print at the true size, and not to fit the paper.
        b"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
        f"<< /Type /Pages /Kids [{kids}] /Count {len(pages)} >>".encode("ascii"),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
    ]
    for width, height, operators in pages:
        box = f"[0 0 {width * POINTS:.4f} {height * POINTS:.4f}]"
        content = operators.encode("latin-1", "replace")
        objects += [
            f"<< /Type /Page /Parent 2 0 R /MediaBox {box} /Contents {len(objects) + 2} 0 R "
            "/Resources << /Font << /F 3 0 R >> >> >>".encode("ascii"),
            b"<< /Length %d >>\nstream\n%s\nendstream" % (len(content), content),
        ]
    result, places = bytearray(b"%PDF-1.4\n"), []
    for number, body in enumerate(objects, 1):
        places.append(len(result))
        result += b"%d 0 obj\n%s\nendobj\n" % (number, body)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    count, begin = len(objects) + 1, len(result)
    result += b"xref\n0 %d\n0000000000 65535 f \n%s" % (count, table)
    result += b"trailer\n<< /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (count, begin)
    return bytes(result)


def _painted(page: PrintedPage) -> list[str]:
    """Return the operators that fill the shapes: a PDF's y points up."""
    lines = [f"q {POINTS:.8f} 0 0 {-POINTS:.8f} 0 {page.height * POINTS:.4f} cm"]
    lines += [f"{0 if shape.black else 1} g {_path(shape)} f" for shape in page.shapes]
    return [*lines, "Q"]


def _path(shape: FilledPolygon) -> str:
    moves = [f"{x:.4f} {y:.4f}" for x, y in shape.points.tolist()]
    return f"{moves[0]} m " + " ".join(f"{move} l" for move in moves[1:]) + " h"


def _written(page: PrintedPage) -> list[str]:
    lines = ["0 g"]
    for text in page.texts:
        words = text.words.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
        x, y = text.x * POINTS, (page.height - text.y) * POINTS
        lines.append(f"BT /F {text.size * POINTS:.3f} Tf {x:.3f} {y:.3f} Td ({words}) Tj ET")
    return lines
