"""``/help``: the documents as pages; every link of every one leads somewhere."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import httpx
import pytest

from app.feature_search import find_features
from app.features.help.markdown import rendered, title_of
from app.settings.config import DOCS, ROOT

pytestmark = pytest.mark.slow

DOCUMENTS = sorted(path.name for path in DOCS.glob("*.md"))
LINK = re.compile(r'(?:href|src)="([^"]+)"')


@pytest.fixture(scope="module")
def client(server):
    with httpx.Client(
        base_url=server.url, timeout=20, trust_env=False, follow_redirects=True
    ) as made:
        yield made


def text_of(client: httpx.Client, name: str) -> str:
    """What a page shows of its document, without the frame."""
    return client.get(f"/help/{name}").text.partition("<main")[2]


def test_all_documents_are_in_the_list_and_the_first_is_the_pages_own(client):
    answer = client.get("/help")
    assert answer.url.path == "/help/"
    listed = re.findall(r'<li><a href="([^"]+)"', answer.text)
    assert listed == DOCUMENTS
    assert 'href="page.md" aria-current=page' in answer.text
    assert '<h1 id="the-page">The page</h1>' in answer.text


@pytest.mark.parametrize("name", DOCUMENTS)
def test_every_link_leads_somewhere(client, name):
    links = LINK.findall(text_of(client, name))
    for link in links:
        if link.startswith("https://"):
            continue
        path, _, anchor = link.partition("#")
        answer = client.get(f"/help/{path or name}")
        assert answer.status_code == 200, link
        assert not anchor or f'id="{anchor}"' in answer.text, link


def test_the_frame_speaks_german_and_the_text_stays(client):
    page = client.get("/help/page.md", headers={"Accept-Language": "de"}).text
    assert '<p class="title">Dokumente</p>' in page
    assert '<h1 id="the-page">The page</h1>' in page
    assert '<main id="text" lang="en"' in page


@pytest.mark.parametrize(
    "name", ["nothing.md", "brickpose.service", "../README.md", "..%2FREADME.md", "pictures/x.svg",
             "pictures/..%2Fpage.md"],
)  # fmt: skip
def test_nothing_else_is_served(client, name):
    assert client.get(f"/help/{name}").status_code == 404


def test_what_is_no_document_is_told_with_those_that_are(client):
    assert "valid are benchmarks.md, " in client.get("/help/other.md").json()["detail"]


def test_html_and_scripts_in_a_document_are_shown_as_text():
    html = rendered('# A\n<script>alert(1)</script> [a](javascript:alert(1)) "<b>"')
    assert "<script" not in html and 'href="javascript' not in html and "<b>" not in html


def test_headings_are_anchors_as_on_github():
    html = rendered("# What `brickpose run` does, and why\n## Way\n## Way\n")
    assert re.findall(r'id="([^"]+)"', html) == ["what-brickpose-run-does-and-why", "way", "way-1"]
    assert title_of("text\n\n# The `one` here\n") == "The one here"


def test_an_installed_program_has_page_fields_documents_and_features_with_it(tmp_path: Path):
    """Not only a checkout does: what a wheel holds is unpacked and asked, far from here."""
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)]
    subprocess.run(build, cwd=ROOT, check=True, capture_output=True, timeout=60)
    (wheel,) = tmp_path.glob("*.whl")
    with ZipFile(wheel) as file:
        file.extractall(tmp_path / "site")
    asked = (
        "from app.feature_search import find_features; "
        "from app.settings.config import DOCS, FRONTEND, MAPS; "
        "print(*(each.name for each in find_features().active), FRONTEND / 'index.html', "
        "FRONTEND / 'features' / 'course' / 'learn.html', MAPS / 'square.svg', DOCS / 'page.md', "
        "DOCS / 'pictures' / 'wide.png', sep='\\n')"
    )
    told = subprocess.run(
        [sys.executable, "-c", asked], cwd=tmp_path, check=True, text=True, capture_output=True,
        timeout=60, env=os.environ | {"PYTHONPATH": str(tmp_path / "site")},
    ).stdout.split()  # fmt: skip
    features, paths = told[:-5], told[-5:]
    assert features == [feature.name for feature in find_features().active]
    for path in map(Path, paths):
        assert path.is_relative_to(tmp_path) and path.is_file()
