# ruff: noqa: E501 - pieces of code are not broken
"""The 22 mistakes of real students, each written into three solutions of different style.

A writing is a base, and texts in it that are replaced. None of them is a formula of the grader's.
"""

from __future__ import annotations

from dataclasses import dataclass

from course.solutions import BASES


@dataclass(frozen=True)
class Writing:
    code: str
    lesson: int
    base: str
    changes: tuple[tuple[str, str], ...]

    @property
    def source(self) -> str:
        return written(self.base, self.changes)


def written(base: str, changes: tuple[tuple[str, str], ...]) -> str:
    source = BASES[base]
    for old, new in changes:
        assert source.count(old) == 1, f"{base}: {source.count(old)} times {old!r}"
        source = source.replace(old, new)
    return source


def _three(code, lesson, arrays, loops, matrices):
    return [
        Writing(code, lesson, base, tuple(changes))
        for base, changes in (("arrays", arrays), ("loops", loops), ("matrices", matrices))
    ]


WRITINGS = [
    *_three(
        "M1", 4,
        [("np.cos(poses[:, 2] + rot1_hat)", "np.cos(rot1_hat)"),
         ("np.sin(poses[:, 2] + rot1_hat)", "np.sin(rot1_hat)")],
        [("[x + w * cos(theta + r1), y + w * sin(theta + r1), wrap(theta + r1 + r2)]",
          "[x + dx * w / (way or 1), y + dy * w / (way or 1), wrap(theta + r1 + r2)]")],
        [("np.exp(1j * (poses[:, 2] + noisy[:, 1]))", "np.exp(1j * noisy[:, 1])")],
    ),
    *_three(
        "M2", 1,
        [("middle = pose[2] + turn / 2", "middle = pose[2] + turn")],
        [("    if abs(turn) < 1e-9:", "    theta = theta + turn\n    if True:"),
         ("y + way * sin(theta), theta\n", "y + way * sin(theta), wrap(theta)\n")],
        [("rotation(pose[2] + 0.5 * turn)", "rotation(wrapped(pose[2] + turn))")],
    ),
    *_three(
        "M3", 4,
        [("sign = -1.0 if dx < 0 else 1.0", "sign = 1.0")],
        [("    if dx < 0:\n        way, rot1 = -way, atan2(-dy, -dx)\n", "")],
        [("back = moved[0] < 0", "back = False")],
    ),
    *_three(
        "M4", 1,
        [("way = (left + right) / 2", "way = (abs(left) + abs(right)) / 2")],
        [("    way = (left + right) / 2", "    way = right")],
        [("step = np.array([0.5 * (left + right), 0.0])",
          "step = np.array([np.sqrt((left**2 + right**2) / 2), 0.0])")],
    ),
    *_three(
        "M5", 4,
        [("rot2**2)) * rng.standard_normal(n)", "rot2**2)) * rng.standard_normal()"),
         ("np.sqrt(a1 * rot1**2 + a2 * way**2) * rng.standard_normal(n)",
          "np.sqrt(a1 * rot1**2 + a2 * way**2) * rng.standard_normal()"),
         ("np.sqrt(a1 * rot2**2 + a2 * way**2) * rng.standard_normal(n)",
          "np.sqrt(a1 * rot2**2 + a2 * way**2) * rng.standard_normal()")],
        [("    for x, y, theta in poses:\n        w =", "    w = r1 = r2 = None\n    for x, y, theta in poses:\n        w = w if w is not None else"),
         ("        r1 = rot1 +", "        r1 = r1 if r1 is not None else rot1 +"),
         ("        r2 = rot2 +", "        r2 = r2 if r2 is not None else rot2 +")],
        [("+ sd * rng.standard_normal((len(poses), 3))", "+ 0 * sd * rng.standard_normal((len(poses), 3))")],
    ),
    *_three(
        "S1", 3,
        [("return np.log(0.95 * fit + 0.05).sum(axis=1)", "return np.log(fit.prod(axis=1))")],
        [("total = 0.0\n        for bearing", "total = 1.0\n        for bearing"),
         ("total += log(0.95 * exp(-0.5 * (away / sigma) ** 2) + 0.05)",
          "total *= 0.95 * exp(-0.5 * (away / sigma) ** 2) + 0.05"),
         ("weights.append(total)", "weights.append(log(total) if total > 0 else -inf)")],
        [("np.sum(np.log(0.05 + 0.95 * np.exp(-d2 / 2 / sigma**2)))",
          "np.log(np.prod(0.05 + 0.95 * np.exp(-d2 / 2 / sigma**2)))")],
    ),
    *_three(
        "S2", 3,
        [("np.exp(-away**2 / (2 * sigma**2))", "np.exp(away**2 / (2 * sigma**2))")],
        [("exp(-0.5 * (away / sigma) ** 2)", "exp(0.5 * (away / sigma) ** 2)")],
        [("np.exp(-d2 / 2 / sigma**2)", "np.exp((-field.distances[i, j]) ** 2 / 2 / sigma**2)")],
    ),
    *_three(
        "S3", 3,
        [("return np.log(0.95 * fit + 0.05).sum(axis=1)", "return 1 / np.abs(away).sum(axis=1)")],
        [("total += log(0.95 * exp(-0.5 * (away / sigma) ** 2) + 0.05)", "total += abs(away)"),
         ("weights.append(total)", "weights.append(1 / total)")],
        [("np.sum(np.log(0.05 + 0.95 * np.exp(-d2 / 2 / sigma**2)))", "1 / (0.0001 + np.sum(d2))")],
    ),
    *_three(
        "S4", 2,
        [("tilt = np.radians(camera.tilt)", "tilt = camera.tilt")],
        [("atan2(y, x), sqrt(x * x + y * y)", "atan2(y, x) * 180 / pi, sqrt(x * x + y * y)")],
        [("t = np.deg2rad(camera.tilt)", "t = np.rad2deg(camera.tilt)")],
    ),
    *_three(
        "S5", 3,
        [("((x - field.origin[0]) / field.cell)", "(x / field.cell)"),
         ("((y - field.origin[1]) / field.cell)", "(y / field.cell)")],
        [("(x - field.origin[0]) // field.cell", "x // field.cell"),
         ("(y - field.origin[1]) // field.cell", "y // field.cell")],
        [("(ends.real - field.origin[0])", "ends.real"),
         ("(ends.imag - field.origin[1])", "ends.imag")],
    ),
    *_three(
        "S6", 3,
        [("angles = poses[:, 2:] + bearings[seen]", "angles = 0 * poses[:, 2:] + bearings[seen]")],
        [("x = px + far * cos(theta + bearing)", "x = px"),
         ("y = py + far * sin(theta + bearing)", "y = py"),
         ("away = field.distances[row][column]", "away = field.distances[row][column] - far")],
        [("np.exp(1j * theta) * local", "local")],
    ),
    *_three(
        "S7", 3,
        [("return np.log(0.95 * fit + 0.05).sum(axis=1)",
          "weights = np.zeros(len(poses))\n    for w, f in zip(weights, fit):\n        w = np.log(0.95 * f + 0.05).sum()\n    return weights")],
        [("    weights = []\n", "    weights = [0.0] * len(poses)\n"),
         ("weights.append(total)", "list(weights).append(total)")],
        [("        result[k] = np.sum", "        copied = result.copy()\n        copied[k] = np.sum")],
    ),
    *_three(
        "S8", 3,
        [("(2 * sigma**2))", "(2 * sigma**4))")],
        [("(away / sigma) ** 2", "(away / (0.3 * sigma)) ** 2")],
        [("np.exp(-d2 / 2 / sigma**2)", "np.exp(-d2 / sigma**2)")],
    ),
    *_three(
        "S9", 2,
        [("x = camera.forward + scale", "x = scale")],
        [(" + camera.forward", "")],
        [("np.array([camera.forward, 0.0, camera.height])", "np.array([0.0, 0.0, camera.height])")],
    ),
    *_three(
        "R1", 5,
        [("poses[drawn], np.full(n, 1 / n)", "poses[drawn], weights[drawn]")],
        [("    result = []\n    i, total", "    result, kept = [], []\n    i, total"),
         ("result.append(list(poses[i]))", "result.append(list(poses[i]))\n        kept.append(weights[i])"),
         ("result, [1 / n] * n", "result, kept")],
        [("np.ones(n) / n", "weights[drawn] / weights[drawn].sum()")],
    ),
    *_three(
        "R2", 5,
        [("poses[drawn], np.full(n, 1 / n)", "poses[drawn], weights")],
        [("result, [1 / n] * n", "result, list(weights)")],
        [("np.ones(n) / n", "weights.copy()")],
    ),
    *_three(
        "R3", 5,
        [("poses[drawn], np.full", "[poses[i] for i in drawn], np.full")],
        [("    result = []\n    i, total", "    poses = [list(pose) for pose in poses]\n    result = []\n    i, total"),
         ("result.append(list(poses[i]))", "result.append(poses[i])")],
        [("return poses[drawn].copy(),", "particles = list(poses)\n    return [particles[i] for i in drawn],")],
    ),
    *_three(
        "R4", 5,
        [(".clip(0, n - 1)", " - 1")],
        [("result.append(list(poses[i]))", "result.append(list(poses[min(i + 1, n - 1)]))")],
        [("drawn = rng.choice(n, size=n, p=weights)",
          "drawn = rng.choice(n, size=n, p=weights)\n    drawn[0] = 0")],
    ),
    *_three(
        "R5", 6,
        [("    if math.hypot(moved[0], moved[1]) < 0.001 and abs(moved[2]) < 0.01:\n        return poses, weights\n", "")],
        [("        return poses, weights\n    poses = parts.motion(poses, moved)\n",
          "        pass\n    else:\n        poses = parts.motion(poses, moved)\n")],
        [("still = np.hypot(*moved[:2]) < 1e-3 and np.abs(moved[2]) < 1e-2", "still = False")],
    ),
    *_three(
        "R6", 6,
        [("weights = weights * np.exp(", "weights = np.exp(")],
        [("    poses = parts.motion(poses, moved)\n",
          "    poses = parts.motion(poses, moved)\n    weights = [1 / len(poses)] * len(poses)\n")],
        [("logs = np.log(weights) + parts", "logs = parts")],
    ),
    *_three(
        "E1", 7,
        [("theta = best[2] + share @ turn\n", "theta = share @ poses[:, 2]\n")],
        [("c, s = c + w * cos(theta), s + w * sin(theta)", "c, s = c + w, s + w * theta"),
         ("atan2(s, c)\n\ndef inject", "s / c\n\ndef inject")],
        [("np.append(mean, np.angle(np.sum(w * np.exp(1j * poses[near, 2]))))",
          "np.append(mean, np.mean(poses[near, 2]))")],
    ),
    *_three(
        "E2", 7,
        [("    theta = (theta + np.pi) % (2 * np.pi) - np.pi\n    return share", "    return share")],
        [("abs(wrap(theta - btheta)) < 0.5", "abs(theta - btheta) < 0.5")],
        [("np.angle(np.sum(w * np.exp(1j * poses[near, 2]))))",
          "np.angle(np.sum(w * np.exp(1j * poses[near, 2]))) % (2 * np.pi))")],
    ),
]  # fmt: skip
CODES = tuple(dict.fromkeys(writing.code for writing in WRITINGS))


def pairs() -> list[tuple[str, str, int, str]]:
    """Two mistakes in one function: codes, lesson, source; not where they touch the same text."""
    made = []
    for index, first in enumerate(WRITINGS):
        for second in WRITINGS[index + 1 :]:
            same = first.lesson == second.lesson and first.base == second.base
            if same and first.code != second.code:
                try:
                    source = written(first.base, first.changes + second.changes)
                except AssertionError:
                    continue
                made.append((first.code, second.code, first.lesson, source))
    return made
