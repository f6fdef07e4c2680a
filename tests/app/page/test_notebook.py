"""The page in a notebook: Python steps, the page shows, and only this computer's pages frame it."""

from __future__ import annotations

import httpx
import pytest

from app.engine.build import build_program
from app.page.notebook import view
from app.settings.config import Config

FRAME = {"sec-fetch-mode": "navigate", "sec-fetch-dest": "iframe", "sec-fetch-site": "cross-site"}


@pytest.fixture(scope="module")
def page():
    program = build_program(Config(robot="kinematic", map="stub", seed=1))
    with view(program, height=400) as shown:
        yield shown
    program.robot.close()


def test_the_page_shows_the_tick_that_python_stepped_to(page):
    assert f'src="{page.address}"' in page._repr_html_()
    assert 'height="400"' in page._repr_html_()
    for _ in range(3):
        last = page.program.engine.step()
        assert httpx.get(f"{page.address}api/state").json()["stamp"] == last.stamp


def test_it_goes_on_for_a_time_of_the_robots_clock(page):
    before = page.program.engine.step().stamp
    assert 0.5 <= page.run(0.5, speed=float("inf")).stamp - before < 0.6


def test_notebooks_of_this_computer_may_frame_it_and_other_sites_may_not(page):
    answer = httpx.get(page.address, headers=FRAME)
    assert answer.status_code == 200
    assert "x-frame-options" not in answer.headers
    allowed = answer.headers["content-security-policy"]
    assert "http://localhost:*" in allowed and "https:" not in allowed.replace(
        "https://localhost", ""
    )
    image = {**FRAME, "sec-fetch-mode": "no-cors", "sec-fetch-dest": "image"}
    assert httpx.get(f"{page.address}camera.jpg", headers=image).status_code == 403
