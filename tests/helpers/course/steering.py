# ruff: noqa: E501 - pieces of code are not broken
"""``source_of`` controllers of lesson 10: right ones in odd styles, mistakes in three writings."""

from __future__ import annotations

from course.mistakes import Writing

HEAD = (
    "import cmath\nimport math\nimport numpy as np\nfrom math import atan2, cos, hypot, pi, sin\n"
)

ARRAYS = """
def go_there(pose, path, goal, speed, ahead, delay):
    if np.linalg.norm(goal[:2] - pose[:2]) < 0.01:
        error, v = goal[2] - pose[2], 0.0
    else:
        away = np.hypot(*(path - pose[:2]).T)
        rest = np.arange(len(path)) >= np.argmin(away)
        found = np.flatnonzero(rest & (away > ahead))
        x, y = path[found[0] if len(found) else -1] - pose[:2]
        error = np.arctan2(y, x) - pose[2]
        v = speed * max(0.0, np.cos(error))
    return v, 0.25 / delay * ((error + np.pi) % (2 * np.pi) - np.pi)
"""

LOOPS = """
def go_there(pose, path, goal, speed, ahead, delay):
    x, y, heading = pose
    gain = 1 / (4 * delay)
    if hypot(goal[0] - x, goal[1] - y) < 0.01:
        return 0, gain * wrap(goal[2] - heading)
    far = [hypot(px - x, py - y) for px, py in path]
    i = far.index(min(far))
    while i < len(path) - 1 and far[i] <= ahead:
        i += 1
    error = wrap(atan2(path[i][1] - y, path[i][0] - x) - heading)
    return speed * max(cos(error), 0), gain * error

def wrap(angle):
    while angle > pi:
        angle -= 2 * pi
    while angle < -pi:
        angle += 2 * pi
    return angle
"""

COMPLEX = """
def go_there(pose, path, goal, speed, ahead, delay):
    here, look = complex(*pose[:2]), cmath.exp(1j * pose[2])
    way = [complex(*point) for point in path]
    there = abs(complex(*goal[:2]) - here) < 0.01
    start = min(range(len(way)), key=lambda k: abs(way[k] - here))
    point = next((p for p in way[start:] if abs(p - here) > ahead), way[-1])
    wanted = cmath.exp(1j * goal[2]) if there else point - here
    error = cmath.phase(wanted / look)
    drive = 0 if there else speed * max(0, cos(error))
    return np.array([drive, 0.25 * error / delay])
"""

BASES = {"arrays": ARRAYS, "loops": LOOPS, "complex": COMPLEX}

ODD = {
    **BASES,
    "sorted": """
def go_there(pose, path, goal, speed, ahead, delay):
    d = ((path - pose[:2]) ** 2).sum(1)
    k = sorted(range(len(d)), key=d.__getitem__)[0]
    k += np.argmax(np.append(d[k:] > ahead**2, True))
    px, py = path[min(k, len(path) - 1)]
    here = np.allclose(goal[:2], pose[:2], rtol=0, atol=0) or math.dist(goal[:2], pose[:2]) < 1e-2
    a = goal[2] - pose[2] if here else math.atan2(py - pose[1], px - pose[0]) - pose[2]
    a = math.atan2(math.sin(a), math.cos(a))
    return [(not here) * speed * np.clip(np.cos(a), 0, None), a / delay / 4]
""",
    "recursive": """
def go_there(pose, path, goal, speed, ahead, delay):
    def first(k):
        return path[k] if k == len(path) - 1 or math.dist(path[k], pose[:2]) > ahead else first(k + 1)
    def turned(angle):
        return math.remainder(angle, math.tau)
    if math.dist(goal[:2], pose[:2]) < 0.01:
        return (0.0, turned(goal[2] - pose[2]) * 0.25 / delay)
    dx, dy = first(int(np.argmin([math.dist(p, pose[:2]) for p in path]))) - pose[:2]
    angle = turned(math.atan2(dy, dx) - pose[2])
    return (speed * math.cos(angle) if abs(angle) < pi / 2 else 0.0, angle * 0.25 / delay)
""",
    "robot frame": """
def go_there(pose, path, goal, speed, ahead, delay):
    c, s = cos(pose[2]), sin(pose[2])
    local = (path - pose[:2]) @ np.array([[c, -s], [s, c]])
    reach = np.linalg.norm(local, axis=1)
    begin = int(reach.argmin())
    beyond = np.nonzero(reach[begin:] > ahead)[0]
    x, y = local[begin + beyond[0]] if beyond.size else local[-1]
    if np.linalg.norm(goal[:2] - pose[:2]) < 0.01:
        x, y = 0.0, 0.0
        error = math.remainder(goal[2] - pose[2], 2 * pi)
    else:
        error = atan2(y, x)
    size = hypot(x, y)
    return np.float64(speed * max(0.0, x / size if size else 0.0)), error / (4.0 * delay)
""",
}


def _three(code, arrays, loops, turned):
    changes = zip(BASES, (arrays, loops, turned), strict=True)
    return [Writing(code, 10, f"steering {base}", tuple(each)) for base, each in changes]


def source_of(writing: Writing) -> str:
    """The source of a writing: a base with some of its texts replaced."""
    base = writing.base.removeprefix("steering ")
    source = BASES[base]
    for old, new in writing.changes:
        assert source.count(old) == 1, f"{base}: {source.count(old)} times {old!r}"
        source = source.replace(old, new)
    return HEAD + source


MISTAKES = [
    *_three(
        "goal-place",
        [("np.linalg.norm(goal[:2] - pose[:2]) < 0.01", "abs(goal[0] - pose[0]) < 0.01")],
        [("hypot(goal[0] - x, goal[1] - y) < 0.01", "max(abs(goal[0] - x), abs(goal[1] - y)) < 0.01")],
        [("abs(complex(*goal[:2]) - here) < 0.01", "abs((complex(*goal[:2]) - here).real) < 0.01")],
    ),
    *_three(
        "ahead-along",
        [("rest & (away > ahead)", "rest & (np.hypot(*(path - path[np.argmin(away)]).T) > ahead)")],
        [("    while i < len(path) - 1 and far[i] <= ahead:", "    nx, ny = path[i]\n    while i < len(path) - 1 and hypot(path[i][0] - nx, path[i][1] - ny) <= ahead:")],
        [("abs(p - here) > ahead", "abs(p - way[start]) > ahead")],
    ),
    *_three(
        "end-lost",
        [("found[0] if len(found) else -1", "found[0] if len(found) else np.argmin(away)")],
        [("    i = far.index(min(far))\n", "    i = far.index(min(far))\n    near = i\n"),
         ("    error = wrap(atan2(", "    i = near if far[i] <= ahead else i\n    error = wrap(atan2(")],
        [("> ahead), way[-1])", "> ahead), way[0])")],
    ),
    *_three(
        "turn-away",
        [("np.arctan2(y, x) - pose[2]", "pose[2] - np.arctan2(y, x)"),
         ("goal[2] - pose[2], 0.0", "pose[2] - goal[2], 0.0")],
        [("cos(error), 0), gain * error", "cos(error), 0), -gain * error")],
        [("wanted / look", "look / wanted")],
    ),
    *_three(
        "E2",
        [("((error + np.pi) % (2 * np.pi) - np.pi)", "error")],
        [("wrap(atan2(path[i][1] - y, path[i][0] - x) - heading)", "atan2(path[i][1] - y, path[i][0] - x) - heading"),
         ("wrap(goal[2] - heading)", "(goal[2] - heading)")],
        [("cmath.phase(wanted / look)", "cmath.phase(wanted) - cmath.phase(look)")],
    ),
    *_three(
        "gain-delay",
        [("0.25 / delay", "2 / delay")],
        [("1 / (4 * delay)", "3.7")],
        [("0.25 * error / delay", "0.25 * error * delay")],
    ),
    *_three(
        "goal-heading",
        [("error, v = goal[2] - pose[2], 0.0", "return 0.0, 0.0")],
        [("    if hypot(goal[0] - x, goal[1] - y) < 0.01:\n        return 0, gain * wrap(goal[2] - heading)\n", "")],
        [("cmath.exp(1j * goal[2]) if there else point - here", "look if there else point - here")],
    ),
    *_three(
        "look-behind",
        [("rest & (away > ahead)", "away > ahead")],
        [("i = far.index(min(far))", "i = 0")],
        [("way[start:] if abs", "way[start::-1] if abs"), ("> ahead), way[-1])", "> ahead), way[0])")],
    ),
    *_three(
        "no-look-ahead",
        [("rest & (away > ahead)", "rest")],
        [("    while i < len(path) - 1 and far[i] <= ahead:\n        i += 1\n", "    i = min(i + 1, len(path) - 1)\n")],
        [("next((p for p in way[start:] if abs(p - here) > ahead), way[-1])", "way[start]")],
    ),
    *_three(
        "corners-cut",
        [("found[0] if len(found) else -1", "-1")],
        [("far[i] <= ahead", "True")],
        [("next((p for p in way[start:] if abs(p - here) > ahead), way[-1])", "way[-1]")],
    ),
    *_three(
        "own-heading",
        [("np.arctan2(y, x) - pose[2]", "np.arctan2(y, x)")],
        [("path[i][0] - x) - heading", "path[i][0] - x) + heading")],
        [("point - here\n    error = cmath.phase(wanted / look)", "(point - here) * look\n    error = cmath.phase(wanted / look)")],
    ),
    *_three(
        "bearing-axes",
        [("np.arctan2(y, x)", "np.arctan2(x, y)")],
        [("atan2(path[i][1] - y, path[i][0] - x)", "atan2(path[i][0] - x, path[i][1] - y)")],
        [("else point - here", "else complex((point - here).imag, (point - here).real)")],
    ),
    *_three(
        "bearing-back",
        [("else -1] - pose[:2]", "else -1] * -1 + pose[:2]")],
        [("path[i][1] - y, path[i][0] - x", "y - path[i][1], x - path[i][0]")],
        [("else point - here", "else here - point")],
    ),
    *_three(
        "full-speed",
        [("speed * max(0.0, np.cos(error))", "speed")],
        [("speed * max(cos(error), 0)", "speed")],
        [("speed * max(0, cos(error))", "speed")],
    ),
    *_three(
        "backwards",
        [("max(0.0, np.cos(error))", "np.cos(error)")],
        [("max(cos(error), 0)", "cos(error)")],
        [("max(0, cos(error))", "(wanted / look).real / abs(wanted)")],
    ),
    *_three(
        "drives-on",
        [("error, v = goal[2] - pose[2], 0.0", "error, v = goal[2] - pose[2], speed * max(0, cos(goal[2] - pose[2]))")],
        [("return 0, gain * wrap(goal[2] - heading)", "return speed * max(0, cos(goal[2] - heading)), gain * wrap(goal[2] - heading)")],
        [("0 if there else speed", "speed")],
    ),
    *_three(
        "goal-away",
        [("goal[2] - pose[2], 0.0", "pose[2] - goal[2], 0.0")],
        [("wrap(goal[2] - heading)", "wrap(heading - goal[2])")],
        [("cmath.exp(1j * goal[2]) if", "look**2 / cmath.exp(1j * goal[2]) if")],
    ),
    *_three(
        "turn-unsigned",
        [("np.arctan2(y, x) - pose[2]", "np.arccos(np.array([x, y]) @ [np.cos(pose[2]), np.sin(pose[2])] / np.hypot(x, y))")],
        [("cos(error), 0), gain * error", "cos(error), 0), abs(gain * error)")],
        [("0.25 * error / delay", "0.25 * math.acos(cos(error)) / delay")],
    ),
    *_three(
        "map-frame",
        [("else -1] - pose[:2]", "else -1]")],
        [("far = [hypot(px - x, py - y) for px, py in path]", "far = [hypot(*point) for point in path]")],
        [("cmath.phase(wanted / look)", "cmath.phase(wanted / look if there else point / look - here)")],
    ),
    *_three(
        "way-direction",
        [("found[0] if len(found) else -1] - pose[:2]", "found[0] if len(found) else -1] - path[np.argmin(away)]")],
        [("atan2(path[i][1] - y, path[i][0] - x)", "atan2(path[i][1] - path[i - 1][1], path[i][0] - path[i - 1][0])")],
        [("else point - here", "else way[min(start + 1, len(way) - 1)] - way[min(start, len(way) - 2)]")],
    ),
    *_three(
        "half-plane",
        [("np.arctan2(y, x)", "np.arctan(y / x)")],
        [("atan2(path[i][1] - y, path[i][0] - x)", "math.asin((path[i][1] - y) / far[i])")],
        [("error = cmath.phase(wanted / look)", "q = wanted / look\n    error = cmath.phase(q) if there else math.atan(q.imag / q.real)")],
    ),
    *_three(
        "ahead-about",
        [("found = np.flatnonzero(rest & (away > ahead))", "found = [np.argmin(abs(away - ahead) + 9 * ~rest)]")],
        [("    while i < len(path) - 1 and far[i] <= ahead:\n        i += 1\n", "    i = min(range(i, len(path)), key=lambda k: abs(far[k] - ahead))\n")],
        [("next((p for p in way[start:] if abs(p - here) > ahead), way[-1])", "min(way, key=lambda p: abs(abs(p - here) - ahead))")],
    ),
    *_three(
        "arc",
        [("0.25 / delay * ((", "2 * v * np.sin(error) / np.hypot(x, y) if v else 0.25 / delay * (("),
         ("        v = speed * max(0.0, np.cos(error))\n", "        v = speed\n")],
        [("    return speed * max(cos(error), 0), gain * error", "    return speed * max(cos(error), 0), gain * far[i] * sin(error)")],
        [("    return np.array([drive, 0.25 * error / delay])", "    turn = 0.25 * error / delay if there else 2 * speed * (wanted / look).imag / ahead**2\n    return np.array([drive, turn])")],
    ),
    *_three(
        "speed-angle",
        [("np.cos(error))", "sum(np.cos([pose[2]])))")],
        [("speed * max(cos(error), 0)", "speed * max((path[i][0] - x) / far[i], 0)")],
        [("max(0, cos(error))", "max(0, wanted.real / abs(wanted))")],
    ),
    *_three(
        "ahead-squared",
        [("(away > ahead)", "(away > ahead * ahead)")],
        [("far[i] <= ahead", "far[i] <= ahead**2")],
        [("abs(p - here) > ahead", "abs(p - here) > ahead**2")],
    ),
    *_three(
        "goal-early",
        [("np.arctan2(y, x) - pose[2]", "goal[2] - pose[2]")],
        [("cos(error), 0), gain * error", "cos(error), 0), gain * wrap(goal[2] - heading)")],
        [("cmath.exp(1j * goal[2]) if there else point - here", "cmath.exp(1j * goal[2])")],
    ),
    *_three(
        "ahead-axis",
        [("rest & (away > ahead)", "(path[:, 0] > pose[0]) & (away > ahead)")],
        [("    while i < len(path) - 1 and far[i] <= ahead:", "    i = 0\n    while i < len(path) - 1 and (far[i] <= ahead or path[i][0] <= x):")],
        [("p for p in way[start:] if abs", "p for p in way if (p / look - here / look).real > 0 and abs")],
    ),
    *_three(
        "S4",
        [("error = np.arctan2(y, x) - pose[2]", "error = np.arctan2(y, x) - pose[2]"),
         ("return v, 0.25 / delay * (", "return v, 0.25 / delay * np.degrees(")],
        [("cos(error), 0), gain * error", "cos(error), 0), gain * math.degrees(error)"),
         ("0, gain * wrap", "0, gain * 180 / pi * wrap")],
        [("0.25 * error / delay", "0.25 * math.degrees(error) / delay")],
    ),
]  # fmt: skip
