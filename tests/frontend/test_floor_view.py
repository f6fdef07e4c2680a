"""From points of the 3D view's picture to points of the floor, by a camera of one's own."""

import math

import numpy as np
import pytest
from viser.transforms import SO3

pytestmark = [pytest.mark.browser, pytest.mark.slow]

SIZE = 640, 360
CAMERAS = {
    "home": ((-0.7, -1.0, 1.0), (0.0, 0.0, 0.0), (0, 0, 1), 75),
    "straight from above": ((0.2, -0.1, 1.4), (0.2, -0.1, 0.0), (0, 1, 0), 75),
    "from above, turned": ((0.0, 0.0, 0.9), (0.0, 0.0, 0.0), (0.6, -0.8, 0), 40),
    "low, with the horizon": ((-1.2, 0.4, 0.15), (0.3, 0.1, 0.1), (0, 0, 1), 75),
    "rolled": ((0.9, 0.6, 0.5), (0.1, 0.0, 0.0), (0.4, 0.3, 1), 60),
    "from below": ((0.5, -0.8, -0.7), (0.0, 0.0, 0.0), (0, 0, 1), 75),
}
"""Where each is, where it looks to, up, and what it sees from top to bottom [degrees]."""

POINTS = """async ([camera, size, points]) => {
  const { FloorView } = await import("/static/view3d/floor_view.js");
  const view = new FloorView(camera, ...size);
  return points.map(({ pixel, floor, from }) => ({
    floor: view.toFloor(pixel),
    pixel: floor && view.toPicture(floor),
    heading: from && view.heading(from, pixel),
  }));
}"""


@pytest.fixture(scope="module")
def blank(browser, server):
    page = browser.new_page()
    page.goto(f"{server.url}/api/health")
    yield page
    page.close()


def matrix_of(eye, target, up, fov):
    """The projection (3, 4) to pixels, by where a camera is and what it looks at."""
    ahead = np.subtract(target, eye) / math.dist(target, eye)
    right = np.cross(ahead, up)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(ahead, right), ahead])
    focal = SIZE[1] / 2 / math.tan(math.radians(fov) / 2)
    lens = np.array([[focal, 0, SIZE[0] / 2], [0, focal, SIZE[1] / 2], [0, 0, 1]])
    return lens @ rotation @ np.column_stack([np.eye(3), -np.array(eye)]), rotation


def message_of(eye, rotation, fov):
    wxyz = SO3.from_matrix(rotation.T).wxyz
    return {"position": list(eye), "wxyz": wxyz.tolist(), "fov": math.radians(fov)}


@pytest.mark.parametrize("name", CAMERAS)
def test_points_of_the_floor_come_back_from_where_they_are_in_the_picture(blank, name):
    eye, target, up, fov = CAMERAS[name]
    matrix, rotation = matrix_of(eye, target, up, fov)
    floor = np.random.default_rng(3).uniform(-1.0, 1.0, (200, 2))
    seen = matrix @ np.column_stack([floor, np.zeros(200), np.ones(200)]).T
    ahead = seen[2] > 0.05
    floor, pixels = floor[ahead], (seen[:2] / seen[2]).T[ahead]
    assert len(floor) > 50
    points = [
        {"pixel": pixel, "floor": place}
        for pixel, place in zip(pixels.tolist(), floor.tolist(), strict=True)
    ]
    back = blank.evaluate(POINTS, [message_of(eye, rotation, fov), SIZE, points])
    assert [each["floor"] for each in back] == [pytest.approx(each, abs=1e-6) for each in floor]
    assert [each["pixel"] for each in back] == [pytest.approx(each, abs=1e-6) for each in pixels]


@pytest.mark.parametrize("name", CAMERAS)
def test_a_line_in_the_picture_has_the_heading_of_the_floor_s_also_above_the_horizon(blank, name):
    eye, target, up, fov = CAMERAS[name]
    matrix, rotation = matrix_of(eye, target, up, fov)
    points, headings, above = [], [], []
    for heading in np.linspace(-3.0, 3.0, 25):
        start = np.array([0.1, -0.05])
        ways = np.outer([0.0, 1e-4], [math.cos(heading), math.sin(heading)])
        ends = matrix @ np.column_stack([start + ways, np.zeros(2), np.ones(2)]).T
        first, second = (ends[:2] / ends[2]).T
        step = (second - first) / np.linalg.norm(second - first)
        for pixels in (20, 200, 900):
            pixel = first + pixels * step
            ray = np.linalg.inv(matrix[:, :3]) @ [*pixel, 1]
            points.append({"pixel": pixel.tolist(), "from": start.tolist()})
            headings.append(heading)
            above.append(ray[2] * eye[2] >= 0)
    back = blank.evaluate(POINTS, [message_of(eye, rotation, fov), SIZE, points])
    assert [each["heading"] for each in back] == pytest.approx(headings, abs=1e-5)
    assert [each["floor"] is None for each in back] == above
    assert any(above) == (name not in ("straight from above", "from above, turned"))
