"""The page that describes the interface."""

import re

import pytest
from fastapi import FastAPI

from app.engine.commands import table
from app.features.interface.docs_page import docs_page
from app.messages.telemetry import TelemetryMessage


@pytest.fixture(scope="module")
def page():
    app = FastAPI(title="Robot <1>")

    @app.get("/api/thing")
    def thing() -> str:
        """A thing, described."""
        return ""

    return docs_page(app.openapi())


def test_nothing_is_fetched_from_elsewhere(page):
    assert re.findall(r'(?:src|href)="(?!openapi\.json"|#)', page) == []
    assert "//" not in page


def test_addresses_are_told(page):
    assert "GET /api/thing" in page
    assert "A thing, described." in page


def test_every_command_and_all_telemetry_is_told(page):
    for command in table():
        assert f'id="{command.__name__}"' in page
    for key in TelemetryMessage.model_fields:
        assert f"<code>{key}</code>" in page


def test_ranges_and_choices_are_told(page):
    assert "number, -10 to 10" in page
    assert "&quot;ok&quot; or &quot;degraded&quot; or &quot;failed&quot;" in page


def test_markup_in_texts_is_no_markup(page):
    assert "Robot &lt;1&gt;" in page
