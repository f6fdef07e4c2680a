"""The page with a link for each student, to print and cut apart: names, links and QR codes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import segno

from app.features.classroom.roster import TEACHER, Student
from app.files import atomic_file

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Links of the class</title>
<meta name="viewport" content="width=device-width">
<style>
body {{ font: 12pt/1.4 system-ui, sans-serif; margin: 1cm; color: #000; background: #fff; }}
ul {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(8cm, 1fr)); gap: 0;
  padding: 0; list-style: none; }}
li {{ border: 1px dashed #888; padding: 4mm; display: flex; gap: 4mm; align-items: center;
  break-inside: avoid; overflow-wrap: anywhere; }}
li svg {{ width: 32mm; height: 32mm; flex: none; }}
h2 {{ font-size: 13pt; margin: 0; }} p {{ margin: 0; font-size: 9pt; }}
.teacher {{ break-after: page; }}
@page {{ margin: 1cm; }}
</style></head><body>
<div class="teacher"><h1>For the teacher</h1>
<p>Who has a link drives that robot and changes its files: give each student their own.</p>
<ul>{teacher}</ul></div>
<ul>{students}</ul>
</body></html>
"""
CARD = '<li>{code}<div><h2>{name}</h2><p><a href="{link}">{link}</a></p></div></li>\n'


def link_of(address: str, key: str) -> str:
    """Return the link with a key, below the hub's address."""
    return f"{address}/hub/enter/{key}"


def write_links(
    path: Path, address: str, students: Sequence[Student], keys: Mapping[str, str]
) -> None:
    """Write the page to a file that only its owner reads."""
    cards = "".join(_card(each.name, link_of(address, keys[each.login])) for each in students)
    teacher = _card("The wall: all robots of the class", link_of(address, keys[TEACHER]))
    with atomic_file(path) as unfinished:
        unfinished.touch(mode=0o600)
        unfinished.write_text(PAGE.format(teacher=teacher, students=cards), encoding="utf-8")


def _card(name: str, link: str) -> str:
    code = segno.make(link, micro=False).svg_inline(scale=3, border=0, omitsize=True)
    return CARD.format(code=code, name=escape(name), link=escape(link))
