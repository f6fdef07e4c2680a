"""Asks about drawings whose size, or whose tape, is not that of a floor.

CAD programs draw hairlines, which are no tape. Drawing programs count in points, in pixels or at a
printer's resolution, and write sizes without a unit. Nothing in such a file says that it is 2.8 or
3.8 times too large; only its tape does, or its numbers, which are round in the unit that was meant.
"""

from __future__ import annotations

from collections.abc import Iterator

from robot.fields.drawing.svg_page import PageSize
from robot.fields.drawing.svg_values import INCH_MM, SvgError, length, shown

USUAL_TAPE_MM = (15.0, 100.0)
"""Widths of tape that nobody is asked about [mm]."""
USUAL_FLOOR_MM = (200.0, 30_000.0)
"""Longer sides of drawings that nobody is asked about [mm]."""

PEN_MM = 2.2
"""The widest pen of CAD programs has 2.11 mm [mm]."""
TAPE_MM = 50.0
"""Width of tape that a hairline is given in examples [mm]."""

LEFT_OUT = "left-out"
"""A field's note on what of its drawing is not on the floor, in words."""
TEXTS = "text in the drawing is no tape, and left out; as a path it would be on the floor"
ANSWER = "data-tape"
"""The attribute of the <svg> that says how wide the tape is: the answer to the question."""

_MEANT = {
    "points": INCH_MM / 72, "pixels": INCH_MM / 96, "dots at 300 dpi": INCH_MM / 300,
    "dots at 600 dpi": INCH_MM / 600, "dots at 150 dpi": INCH_MM / 150, "millimetres": 1.0,
    "centimetres": 10.0, "inches": INCH_MM, "metres": 1000.0,
}  # fmt: skip
"""Units that programs draw in [mm]; the first that fits is asked about."""

_ROLLS_MM = (
    12.0, 15.0, 19.0, 20.0, 24.0, 25.0, 25.4, 30.0, 36.0, 38.0, 40.0, 48.0, 50.0, 50.8, 75.0,
)  # fmt: skip
"""Widths in which tape is sold [mm]."""


def ask(size: PageSize, tape: float, answer: str) -> None:
    """Ask if the tape's width [mm] is not what tape is, or if the numbers are round in points.

    Raises:
        SvgError: there is a question, or the answer is another width; it names the cure.
    """
    if answer.strip():
        _compare(answer, tape)
        return
    if tape < PEN_MM:
        raise SvgError(
            f"the tape is {tape:.3g} mm wide: {_cure(size, tape)}, or "
            f'if it is right as it is, give the <svg> {ANSWER}="{tape:.3g}"'
        )
    long = max(size.width, size.height)
    if not USUAL_TAPE_MM[0] <= tape <= USUAL_TAPE_MM[1]:
        wrong = f"the tape is {tape:.3g} mm wide"
    elif not USUAL_FLOOR_MM[0] <= long <= USUAL_FLOOR_MM[1]:
        wrong = f"the floor is {size.width:.4g} x {size.height:.4g} mm"
    elif not size.has_unit and _round_elsewhere(size):
        wrong = f"its size has no unit, which is {size.width:g} x {size.height:g} mm"
    else:
        return
    unit = next(_units(size, tape), "points" if tape > USUAL_TAPE_MM[1] else "millimetres")
    width, height, box = _sides(size, _MEANT[unit])
    raise SvgError(
        f"{wrong}: was this drawn in {unit}? "
        f'If so, give the <svg> width="{width}mm" height="{height}mm"{box}, which makes the tape '
        f"{tape * _MEANT[unit] * size.box[0] / size.width:.3g} mm wide; "
        f'if it is right as it is, give the <svg> {ANSWER}="{tape:.3g}"'
    )


def refuse_thin(size: PageSize, tape: float, valid: tuple[float, float]) -> None:
    """Refuse strokes that are thinner than tape can be [mm].

    Raises:
        SvgError: names the cure.
    """
    low, high = valid
    raise SvgError(
        f"a stroke of tape is {tape:.3g} mm wide, and valid is {low:g} to {high:g}: "
        f"{_cure(size, tape)}, or if it is no tape, remove it"
    )


def refuse_invisible(size: PageSize) -> None:
    """Refuse a drawing whose lines have no width.

    Raises:
        SvgError: names the cure.
    """
    width = TAPE_MM * size.box[0] / size.width
    raise SvgError(
        "there is no tape: lines have the stroke-width 0, as hairlines of CAD programs: give them "
        f'that of tape, stroke-width="{width:.4g}" is {TAPE_MM:g} mm here'
    )


def _cure(size: PageSize, tape: float) -> str:
    """Return what makes tape of hairlines, or of the numbers of a larger unit."""
    factor = TAPE_MM / tape
    times = f"{factor:.3g}" if factor < 1000 else f"{factor:.0f}"
    unit = next((name for name in _units(size, tape) if _is_floor(size, name)), None)
    if unit is None:
        return (
            f"if it is a hairline of a CAD program, make its stroke-width {times} times as large, "
            f"for tape of {TAPE_MM:g} mm"
        )
    width, height, box = _sides(size, _MEANT[unit])
    return (
        f"if it is a hairline of a CAD program, make its stroke-width {times} times as large, for "
        f"tape of {TAPE_MM:g} mm, or if it was drawn in {unit}, give the <svg> "
        f'width="{width}mm" height="{height}mm"{box}'
    )


def _is_floor(size: PageSize, unit: str) -> bool:
    """Return whether the drawing is as large as floors are, if it is in a unit."""
    long = max(size.width, size.height) * _MEANT[unit] * size.box[0] / size.width
    return USUAL_FLOOR_MM[0] <= long <= USUAL_FLOOR_MM[1]


def _sides(size: PageSize, factor: float) -> tuple[str, str, str]:
    """Return width, height [mm] and the viewBox that make a unit so many millimetres."""
    # Without a viewBox a size with a unit is that of the page alone, and is kept.
    is_pages = size.has_unit and not size.has_box
    sides = (size.width / factor, size.height / factor) if is_pages else size.box
    width, height = (f"{side * factor:.6g}" for side in sides)
    box = "" if size.has_box else f' viewBox="0 0 {sides[0]:.6g} {sides[1]:.6g}"'
    return width, height, box


def _compare(answer: str, tape: float) -> None:
    written = length(answer)
    if written is None or written.unit not in ("", "mm"):
        raise SvgError(f"{ANSWER} is {shown(answer)}; valid is the tape's width [mm]")
    if abs(written.value - tape) > 0.05 * tape:
        raise SvgError(
            f"{ANSWER} is {shown(answer)}, but the tape is {tape:.3g} mm wide: "
            "correct it, or the width and height of the <svg>"
        )


def _units(size: PageSize, tape: float) -> Iterator[str]:
    """Yield the units in which it is a floor: of rolls that are sold first, then any."""
    # What the drawing's own numbers are now [mm].
    unit_now = size.width / size.box[0]
    others = {name: unit for name, unit in _MEANT.items() if abs(unit / unit_now - 1) > 0.01}
    round_ = [name for name, unit in others.items() if _are_round(size.box, unit)]
    for choice in (round_ if not _are_round(size.box, unit_now) else [], others):
        for name in choice:
            width = tape * _MEANT[name] / unit_now
            if any(abs(width / roll - 1) < 0.01 for roll in _ROLLS_MM):
                yield name
    for name, unit in others.items():
        if USUAL_TAPE_MM[0] <= tape * unit / unit_now <= USUAL_TAPE_MM[1]:
            yield name


def _round_elsewhere(size: PageSize) -> bool:
    """Return whether both sides are whole millimetres in points or pixels, but not as they are."""
    candidates = [unit for name, unit in _MEANT.items() if name in ("points", "pixels")]
    return not _are_round(size.box, size.width / size.box[0]) and any(
        _are_round(size.box, unit) for unit in candidates
    )


def _are_round(sides: tuple[float, float], unit: float) -> bool:
    """Return whether sides are whole millimetres, as far as programs write them."""
    return all(abs(side * unit - round(side * unit)) < 0.02 for side in sides)
