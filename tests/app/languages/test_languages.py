"""Languages: their files, how texts are found in code and in what the program has said."""

from __future__ import annotations

import json
import re
from itertools import product
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.engine.commands import parse
from app.languages.catalogue import FOLDER, Catalogue, catalogue, languages, spoken
from app.languages.docstrings import in_language
from app.languages.extraction import (
    ROOT,
    SILENT,
    SPEAKING,
    TELLING,
    Text,
    _in_python,
    texts,
    texts_of_page,
)
from app.languages.markup import translated
from app.languages.python_texts import texts_of_module
from app.languages.script_texts import texts_of_script
from app.languages.templates import PLACE, Templates, filled
from app.languages.update import faults, read, updated
from app.page.language import accepted
from robot.errors import CommandError

pytestmark = pytest.mark.slow

GERMAN = Templates(
    {
        "{name} is {x}; valid is {low} to {high}": "{name} ist {x}; gültig: {low} bis {high}",
        "the camera {name} failed: {error}": "die Kamera {name} fiel aus: {error}",
        "it is gone": "sie ist weg",
        "no picture": "kein Bild",
        "dark{places} may not be there": "Dunkles{places} ist vielleicht nicht da",
        "at {some}": "bei {some}",
    },
    ",",
)


@pytest.mark.parametrize(
    ("told", "wanted"),
    [
        ("it is gone", "sie ist weg"),
        ("x is 2.5; valid is 0 to 1", "x ist 2,5; gültig: 0 bis 1"),
        ("the camera 0 failed: it is gone", "die Kamera 0 fiel aus: sie ist weg"),
        ("sensor.toml: x is 3; valid is -1.5 to 1", "sensor.toml: x ist 3; gültig: -1,5 bis 1"),
        ("no picture; it is gone", "kein Bild; sie ist weg"),
        ("dark at 2 m may not be there", "Dunkles bei 2 m ist vielleicht nicht da"),
        ("nobody has translated this", "nobody has translated this"),
        ("version 2.5.1", "version 2.5.1"),
        ("", ""),
    ],
)
def test_what_was_told_is_found_by_its_text(told: str, wanted: str) -> None:
    assert GERMAN.translated(told) == wanted


@given(st.text(max_size=200))
def test_no_text_is_lost(told: str) -> None:
    assert GERMAN.translated(told) or not told


def test_a_page_keeps_all_but_its_words() -> None:
    page = """<!doctype html><html lang="en"><meta name="description" content="A page">
    <p id="a" title="It &amp; that">  One &lt; <b>two</b> three </p><code>One</code><br>
    <svg><path d="M 0 0"/></svg><b translate="no">One <i>two</i></b> One<script>let One;</script>"""
    assert translated(page, lambda text: text) == page
    assert texts_of_page(page) == ["A page", "It & that", "One <", "two", "three", "One"]
    assert '<b>"TWO"</b>' in translated(page, lambda text: f'"{text.upper()}"')
    assert 'title="&quot;IT &amp; THAT&quot;"' in translated(page, lambda t: f'"{t.upper()}"')


def test_texts_of_python_are_found_as_they_will_be_told(tmp_path: Path) -> None:
    module = tmp_path / "module.py"
    module.write_text(
        '"""Some documentation."""\n'
        "def f(a, b):\n"
        '    raise OddError(f"{a.path} has {len(b.items)} of {b.items[0]:.1f}; " + a.path)\n'
        'x = phrase("marked")\n'
        'z = "not a text"\n'
        'problems.note(stamp, f"nothing to {x}")\n'
        'words.append("one more")\n'
        'LOG.warning("for the log")\n'
    )
    assert set(texts_of_module(module, errors=True, all_of_it=False)) == {
        "{path} has {items} of {value}; {path}",
        "nothing to {x}",
        "marked",
    }
    assert set(texts_of_module(module, errors=False, all_of_it=False)) == {"marked"}
    every = set(texts_of_module(module, errors=False, all_of_it=True))
    assert {"not a text", "one more"} <= every and "for the log" not in every


def test_numbers_have_the_languages_decimal_sign() -> None:
    assert catalogue("de").t("{x} mm", x=2.5) == "2,5 mm"
    assert catalogue("en").t("{x} mm", x=2.5) == "2.5 mm"


@pytest.mark.parametrize(
    ("environment", "wanted"),
    [
        ({}, "en"),
        ({"LANG": "de_DE.UTF-8"}, "de"),
        ({"LANG": "de_DE.UTF-8", "LANGUAGE": "fr:en"}, "en"),
        ({"LANG": "C.UTF-8"}, "en"),
        ({"LC_ALL": "de", "LANG": "en_GB"}, "de"),
    ],
)
def test_commands_speak_the_language_of_the_environment(environment, wanted) -> None:
    assert spoken(environment).language == wanted


@pytest.mark.parametrize(
    ("header", "wanted"),
    [
        ("", [""]),
        ("de-AT,de;q=0.9,en;q=0.8", ["de", "de", "en"]),
        ("fr;q=0.2, de", ["de", "fr"]),
        ("de;q=0, en;q=broken, fr", ["fr"]),
    ],
)
def test_browsers_languages_are_read_in_their_order(header: str, wanted: list[str]) -> None:
    assert accepted(header) == wanted


def test_there_are_english_and_german() -> None:
    assert languages()[:2] == ("en", "de")


def test_listed_modules_exist() -> None:
    """A module that is moved takes its place in the lists along."""
    assert not [way for way in (*TELLING, *SPEAKING, *SILENT) if not (ROOT / way).exists()]


@pytest.fixture(scope="module")
def wanted() -> set[Text]:
    return texts()


@pytest.mark.parametrize("code", languages()[1:])
def test_a_language_has_each_text_with_its_places_and_no_more(code: str, wanted) -> None:
    found = faults(read(FOLDER / f"{code}.po"), wanted)
    assert not found, "run python -m app.languages.update, and translate what is new"


def test_a_fault_of_each_kind_is_found() -> None:
    wanted: set[Text] = {"new", "{x} mm", ("{count} ray", "{count} rays")}
    old = read(FOLDER / "de.po")
    half = updated(old, {"{x} mm", "gone"})
    half["{x} mm"].string = "{y} mm"
    told = faults(half, wanted)
    assert told == ["lacks: new", "lacks: {count} ray", "is in no code: gone",
                    "has other places: {y} mm"]  # fmt: skip


def test_texts_of_scripts_are_found() -> None:
    script = """export function t(text) {}
    a(`${t("one")}`, t("two {x}", { x: t("three") }), set("no"), tn(
      "{count} ray",
      "{count} rays", 2), that.t("no"), start("no"));"""
    assert list(texts_of_script(script)) == [
        "one", "two {x}", "three", ("{count} ray", "{count} rays"),
    ]  # fmt: skip
    with pytest.raises(ValueError, match=r"line 2: .* written out"):
        list(texts_of_script("\nt(words)"))


NOT_SAID = re.compile(r"/\*.*?\*/|//[^\n]*|(new Error|console\.\w+)\([^;]*;", re.DOTALL)
"""Comments, and what only developers read."""
SENTENCE = re.compile(r"""(["`])((?:(?!\1)[^\\\n]|\\.)*)\1""")
"""A string of JavaScript."""


def test_no_script_says_a_sentence_that_is_no_text(wanted) -> None:
    """What is an error of the page's own code, a selector or a format is none."""
    known = {each for text in wanted for each in ([text] if isinstance(text, str) else text)}
    for path in sorted((ROOT / "frontend").rglob("*.js")):
        code = re.sub(
            r"/\*.*?\*/|//[^\n]*|(new Error|console\.\w+)\([^;]*;", "", path.read_text(), flags=re.S
        )
        said = {re.sub(r"\$\{.*\}", "", match[2]) for match in SENTENCE.finditer(code)}
        words = {text for text in said if re.search(r"[a-z]{2,} [a-z]{2,} [a-z]{2,}", text)}
        assert words <= known, path.name


def test_the_programs_own_words_are_told_in_german() -> None:
    own = catalogue("de")
    assert own.translated("max_particles is 5; valid is 10 to 20000") == (
        "max_particles ist 5; gültig ist 10 bis 20000"
    )
    told = "The robot stands still: mine.py line 3: Mine gives None; is its `return` missing?"
    assert "mine.py line 3: Mine liefert None; fehlt das `return`?" in own.translated(told)
    late = own.translated("pictures seem to come 20 ms late")
    assert late == "Bilder scheinen 20 ms zu spät zu kommen"
    assert own.translated("program 2 at 192.168.1.7") == "Programm 2 auf 192.168.1.7"


@pytest.mark.parametrize("code", languages()[1:])
def test_each_text_of_python_is_found_again_with_values_in_it(code: str) -> None:
    """No other text takes a finished message for its own, unless it says the same."""
    own = catalogue(code)
    told = sorted({text for text in _in_python(ROOT) if isinstance(text, str)})
    for text, value in product(told, ("7", "wheel", "/home/eva/field.svg")):
        names = sorted(set(PLACE.findall(text)))
        values = {name: f"{value}{number}" for number, name in enumerate(names)}
        assert own.translated(filled(text, values)) == filled(own.texts[text][0], values)


def test_numbers_in_a_row_are_apart_by_more_than_a_decimal_sign() -> None:
    assert GERMAN.translated("0.5, 0, -1.2e-05, ...") == "0,5; 0; -1,2e-05; ..."
    assert Templates({}, ".").translated("0.5, 0") == "0.5, 0"


def test_a_short_word_between_values_is_not_looked_for_in_sentences() -> None:
    german = Templates({"{low} to {high}": "{low} bis {high}"}, ",")
    assert german.translated("0.5 to 1 m") == "0,5 bis 1 m"
    told = "TypeError: only length-1 arrays can be converted to Python scalars"
    assert german.translated(told) == told


def test_an_attribute_with_an_apostrophe_is_translated() -> None:
    page = """<b title="It's &lt; 1">one</b>"""
    assert translated(page, str.upper) == """<b title="IT&#x27;S &lt; 1">ONE</b>"""


def test_code_speaks_another_language_only_in_its_docstrings() -> None:
    source = (
        '"""A thing."""\n\n\ndef f(x):\n    """Give it.\n\n    It is\n    x.\n    """\n    raise\n'
    )
    assert in_language(source, catalogue("en")) == source
    own = Catalogue("de", {"A thing.": ("Ein Ding.",), "It is x.": ("x ist es.",)}, "", ",")
    wanted = source.replace("A thing", "Ein Ding").replace("It is\n    x", "x ist es")
    assert in_language(source, own) == wanted


@pytest.mark.parametrize(
    ("command", "wanted"),
    [
        (
            {"type": "undo", "colour": 3},
            "undo.colour ist unbekannt; gültig sind 'id', 'sent', 'type'",
        ),
        ({"type": "place", "x": 2e4, "y": 0, "theta": 0}, "place.x: Gültig ist höchstens 10000"),
        ({"type": "place", "x": "0", "y": 0, "theta": 0}, "place.x: Gültig ist eine Zahl"),
        ({"type": "place", "x": 0, "y": 0}, "place.theta: Das muss dabei sein"),
        ({"type": "set_pose", "x": 0, "y": 0, "theta": 0, "sd_xy": 0}, ".sd_xy: Gültig ist mehr"),
        ({"type": "set_particles", "poses": []}, "set_particles.poses: Die Liste hat 0 Einträge;"),
        ({}, "Es fehlt 'type'"),
    ],
)
def test_refusals_of_pydantic_are_german(command, wanted):
    with pytest.raises(CommandError) as refused:
        parse(json.dumps(command))
    assert wanted in catalogue("de").translated(str(refused.value))


def test_what_is_no_json_is_refused_in_german():
    with pytest.raises(CommandError) as refused:
        parse("{")
    assert catalogue("de").translated(str(refused.value)).startswith("Kein JSON: ")
