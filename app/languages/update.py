"""``python -m app.languages.update [CODE]``: bring language files up to date with the code.

New texts are added without a translation, and those that the code has no more are dropped. With a
code, as ``fr``, a new file is begun. It ends with 1 while something is left to translate.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path

from babel.messages.catalog import Catalog, Message
from babel.messages.pofile import read_po, write_po

from app.languages.catalogue import FOLDER, languages
from app.languages.extraction import Text, texts
from app.languages.templates import PLACE

WIDTH = 100
HEADER = """\
# {name}: texts of page, lessons and commands. `python -m app.languages.update` adds new ones.
msgid ""
msgstr ""
"Language: {code}\\n"
"Plural-Forms: {plural}\\n"
"Content-Type: text/plain; charset=utf-8\\n"

"""


def updated(old: Catalog, wanted: set[Text]) -> Catalog:
    """Return a catalogue of the wanted texts, with the translations that the old one has."""
    new = Catalog(locale=old.locale)
    new.mime_headers = old.mime_headers
    for text in wanted:
        known = old.get(text)
        same = known is not None and known.id == text
        new.add(text, known.string if known and same else None)
    return new


def written(catalog: Catalog) -> str:
    """Return a language's file: sorted, so that two people's additions seldom collide."""
    file = BytesIO()
    for entry in catalog:
        entry.flags.clear()  # ours are in no format of Python's
    write_po(file, catalog, width=WIDTH, sort_output=True, omit_header=True)
    assert catalog.locale is not None
    head = HEADER.format(
        name=catalog.locale.english_name, code=catalog.locale, plural=catalog.plural_forms
    )
    return head + file.getvalue().decode()


def read(path: Path) -> Catalog:
    """Read a language's file; an empty catalogue if it is not there."""
    if not path.is_file():
        return Catalog(locale=path.stem)
    with path.open("rb") as file:
        return read_po(file, locale=path.stem, abort_invalid=True)


def faults(catalog: Catalog, wanted: set[Text]) -> list[str]:
    """Return what is wrong with a catalogue: texts that it lacks or has too many, other places."""
    entries = {_key(entry.id): entry for entry in catalog if entry.id}
    keys = {_key(text): text for text in wanted}
    lacks = [
        f"lacks: {text}"
        for text in sorted(keys)
        if text not in entries or not all(_forms(entries[text].string))
    ]
    spare = [f"is in no code: {text}" for text in sorted(set(entries) - set(keys))]
    return lacks + spare + [fault for entry in entries.values() for fault in _places(entry)]


def _places(entry: Message) -> list[str]:
    ids, forms = _forms(entry.id), _forms(entry.string)
    known = {name for text in ids for name in PLACE.findall(text)}
    return [
        f"has other places: {form}"
        for form in forms
        if form and not (known - {"count"} <= set(PLACE.findall(form)) <= known)
    ]


def _key(text: str | Sequence[str]) -> str:
    return _forms(text)[0]


def _forms(text: str | Sequence[str] | None) -> tuple[str, ...]:
    return (text or "",) if isinstance(text, str | None) else tuple(text)


def main(arguments: list[str] | None = None) -> int:
    """Update all language files, or begin one; return 1 if something is left to translate."""
    parser = argparse.ArgumentParser(prog="python -m app.languages.update", description=__doc__)
    parser.add_argument("code", nargs="?", help="a language to begin, as fr")
    parser.add_argument("--check", action="store_true", help="only tell what is to do")
    options = parser.parse_args(arguments)
    wanted = texts()
    codes = [options.code] if options.code else languages()[1:]
    left: list[str] = []
    for code in codes:
        path = FOLDER / f"{code}.po"
        catalog = read(path)
        if not options.check:
            catalog = updated(catalog, wanted)
            path.write_text(written(catalog), encoding="utf-8")
        left += [f"{code}.po {fault}\n" for fault in faults(catalog, wanted)]
    sys.stdout.writelines(left)
    return 1 if left else 0


if __name__ == "__main__":
    sys.exit(main())
