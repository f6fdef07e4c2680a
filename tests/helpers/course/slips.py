# ruff: noqa: E501 - pieces of code are not broken
"""Slips of a beginner who did the lessons from their text alone, and the cause that tells each."""

from __future__ import annotations

SLIPS: list[tuple[str, int, list[tuple[str, str]]]] = [
    ("brackets", 1, [("way = (left + right) / 2", "way = left + right / 2")]),
    ("brackets", 1, [("turn = (right - left) / track", "turn = right - left / track")]),
    ("offset-late", 2, [("camera.forward + scale * (np", "scale * (np"), ("np.hypot(x, y)\n", "np.hypot(x, y) + camera.forward\n")]),
    ("rotation", 2, [("(np.cos(tilt) - down", "(np.cos(tilt) + down")]),
    ("side", 2, [("y = -scale * right", "y = -right")]),
    ("exchanged", 2, [("np.arctan2(y, x), np.hypot(x, y)\n", "np.hypot(x, y), np.arctan2(y, x)\n")]),
    ("horizon-early", 2, [("if fall <= 0:", "if v < camera.v0:")]),
    ("heading-sign", 3, [("poses[:, 2:] + bearings[seen]", "bearings[seen] - poses[:, 2:]")]),
    ("sigma", 3, [("-away**2 / (2 * sigma**2)", "-away**2 / 2 * sigma**2")]),
    ("outliers", 3, [("np.log(0.95 * fit + 0.05)", "np.log(0.95 * fit)")]),
    ("second-turn", 4, [("(turn - rot1 + np.pi)", "(turn + np.pi)")]),
    ("variances", 4, [("(rot1**2 + rot2**2)", "(rot1 + rot2)**2")]),
    ("arctan", 4, [("np.arctan2(sign * dy, sign * dx)", "np.arctan2(dx, dy) if dx >= 0 else np.arctan2(-dy, -dx)")]),
    ("line", 5, [("np.cumsum(weights)", "weights")]),
    ("line", 5, [("(rng.random() + np.arange(n)) / n", "rng.random() + np.arange(n) / n")]),
    ("weights-ignored", 5, [("np.searchsorted(np.cumsum(weights), places).clip(0, n - 1)", "rng.integers(0, n, n)")]),
    ("no-chance", 5, [("(rng.random() + np.arange(n)) / n", "(0.5 + np.arange(n)) / n")]),
    ("order", 6, [("    poses = parts.motion(poses, moved)\n    fits = parts.log_weight(poses, scan)\n", "    fits = parts.log_weight(poses, scan)\n    poses = parts.motion(poses, moved)\n")]),
    ("standing", 6, [("< 0.001 and abs", "< 0.001 or abs")]),
    ("survivors-lost", 6, [("poses, weights = parts.resample", "parts.resample")]),
    ("field-size", 7, [("[right, top, np.pi]", "[left + right, bottom + top, np.pi]")]),
    ("shares", 7, [("share @ poses[:, 0], share @ poses[:, 1], theta", "(weights * near) @ poses[:, 0], (weights * near) @ poses[:, 1], theta")]),
    ("heaviest", 7, [("np.argmax", "np.argmin")]),
    ("not-written", 7, [("    best = poses", "    raise NotImplementedError\n    best = poses")]),
    ("ratio", 8, [("max(0.0, 1 - memory.fast / memory.slow)", "abs(1 - memory.fast / memory.slow)")]),
    ("all-new", 8, [("rng.random(len(poses)) < share", "np.full(len(poses), rng.random() < share)")]),
    ("one-place", 8, [("anywhere(int(new.sum()))", "anywhere(1)")]),
]  # fmt: skip
"""Cause, lesson, and what is replaced in the solution with arrays."""
