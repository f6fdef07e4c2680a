"""Languages: their files, how texts are found in code and in what the program has said."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.languages.catalogue import Catalogue, catalogue, languages, spoken
from app.languages.markup import texts_of_page, translated
from app.languages.python_texts import texts_of_module
from app.languages.templates import Templates
from app.page.language import accepted

GERMAN = Templates(
    {
        "{name} is {x}; valid is {low} to {high}": "{name} ist {x}; gültig: {low} bis {high}",
        "the camera {name} failed: {error}": "die Kamera {name} fiel aus: {error}",
        "it is gone": "sie ist weg",
        "no picture": "kein Bild",
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
        'x = text("marked")\n'
        'y = tn("one thing", "{count} things", 3)\n'
        'z = "not a text"\n'
    )
    assert set(texts_of_module(module, errors=True, all_of_it=False)) == {
        "{path} has {items} of {value}; {path}",
        "marked",
        ("one thing", "{count} things"),
    }
    assert set(texts_of_module(module, errors=False, all_of_it=False)) == {
        "marked",
        ("one thing", "{count} things"),
    }
    assert "not a text" in set(texts_of_module(module, errors=False, all_of_it=True))


def test_plurals_follow_the_languages_rule() -> None:
    polish = Catalogue(
        "pl",
        {"{count} ray": ("{count} promień", "{count} promienie", "{count} promieni")},
        "n==1 ? 0 : n%10>=2 && n%10<=4 && (n%100<10 || n%100>=20) ? 1 : 2",
        ",",
    )
    told = [polish.tn("{count} ray", "{count} rays", n) for n in (1, 2, 5, 22)]
    assert told == ["1 promień", "2 promienie", "5 promieni", "22 promienie"]
    english = catalogue("en")
    assert [english.tn("{count} ray", "{count} rays", n) for n in (1, 2)] == ["1 ray", "2 rays"]


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
