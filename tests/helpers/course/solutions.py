"""Correct solutions of all lessons in several styles; the wrong ones are made from them."""

ARRAYS = """
import math
import numpy as np

def odometry(pose, left, right, track):
    way = (left + right) / 2
    turn = (right - left) / track
    middle = pose[2] + turn / 2
    theta = (pose[2] + turn + math.pi) % (2 * math.pi) - math.pi
    return np.array([pose[0] + way * math.cos(middle), pose[1] + way * math.sin(middle), theta])

def project(u, v, camera):
    tilt = np.radians(camera.tilt)
    right = (u - camera.u0) / camera.focal
    down = (v - camera.v0) / camera.focal
    fall = np.sin(tilt) + down * np.cos(tilt)
    if fall <= 0:
        return 0.0, np.inf
    scale = camera.height / fall
    x = camera.forward + scale * (np.cos(tilt) - down * np.sin(tilt))
    y = -scale * right
    return np.arctan2(y, x), np.hypot(x, y)

def log_weight(poses, bearings, ranges, field, sigma):
    seen = np.isfinite(ranges)
    angles = poses[:, 2:] + bearings[seen]
    x = poses[:, :1] + ranges[seen] * np.cos(angles)
    y = poses[:, 1:2] + ranges[seen] * np.sin(angles)
    columns = ((x - field.origin[0]) / field.cell).astype(int)
    rows = ((y - field.origin[1]) / field.cell).astype(int)
    height, width = field.distances.shape
    away = field.distances[rows.clip(0, height - 1), columns.clip(0, width - 1)]
    fit = np.exp(-away**2 / (2 * sigma**2))
    return np.log(0.95 * fit + 0.05).sum(axis=1)

def motion(poses, moved, alphas, rng):
    n, (dx, dy, turn), (a1, a2, a3, a4) = len(poses), moved, alphas
    sign = -1.0 if dx < 0 else 1.0
    way, rot1 = sign * np.hypot(dx, dy), np.arctan2(sign * dy, sign * dx)
    rot2 = (turn - rot1 + np.pi) % (2 * np.pi) - np.pi
    way_hat = way + np.sqrt(a3 * way**2 + a4 * (rot1**2 + rot2**2)) * rng.standard_normal(n)
    rot1_hat = rot1 + np.sqrt(a1 * rot1**2 + a2 * way**2) * rng.standard_normal(n)
    rot2_hat = rot2 + np.sqrt(a1 * rot2**2 + a2 * way**2) * rng.standard_normal(n)
    x = poses[:, 0] + way_hat * np.cos(poses[:, 2] + rot1_hat)
    y = poses[:, 1] + way_hat * np.sin(poses[:, 2] + rot1_hat)
    theta = (poses[:, 2] + rot1_hat + rot2_hat + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([x, y, theta])

def resample(poses, weights, rng):
    n = len(weights)
    places = (rng.random() + np.arange(n)) / n
    drawn = np.searchsorted(np.cumsum(weights), places).clip(0, n - 1)
    return poses[drawn], np.full(n, 1 / n)

def loop(poses, weights, moved, scan, parts):
    if math.hypot(moved[0], moved[1]) < 0.001 and abs(moved[2]) < 0.01:
        return poses, weights
    poses = parts.motion(poses, moved)
    fits = parts.log_weight(poses, scan)
    weights = weights * np.exp(fits - np.max(fits))
    weights = weights / weights.sum()
    if 1 / (weights**2).sum() < len(poses) / 2:
        poses, weights = parts.resample(poses, weights)
    return poses, weights

def init(extent, count, rng):
    left, bottom, right, top = extent
    return rng.uniform([left, bottom, -np.pi], [right, top, np.pi], (count, 3))

def estimate(poses, weights):
    best = poses[np.argmax(weights)]
    off = poses - best
    turn = (off[:, 2] + np.pi) % (2 * np.pi) - np.pi
    near = (np.hypot(off[:, 0], off[:, 1]) < 0.1) & (np.abs(turn) < 0.5)
    share = weights * near / np.sum(weights * near)
    theta = best[2] + share @ turn
    theta = (theta + np.pi) % (2 * np.pi) - np.pi
    return share @ poses[:, 0], share @ poses[:, 1], theta

def inject(poses, fit, memory, anywhere, rng):
    memory.slow += 0.05 * (fit - memory.slow)
    memory.fast += 0.5 * (fit - memory.fast)
    share = max(0.0, 1 - memory.fast / memory.slow)
    new = rng.random(len(poses)) < share
    result = poses.copy()
    result[new] = anywhere(int(new.sum()))
    return result
"""

LOOPS = """
from math import atan2, cos, exp, hypot, inf, isinf, log, pi, radians, sin, sqrt

def wrap(angle):
    while angle >= pi:
        angle -= 2 * pi
    while angle < -pi:
        angle += 2 * pi
    return angle

def odometry(pose, left, right, track):
    x, y, theta = pose
    way = (left + right) / 2
    turn = (right - left) / track
    if abs(turn) < 1e-9:
        return x + way * cos(theta), y + way * sin(theta), theta
    radius = way / turn
    x += radius * (sin(theta + turn) - sin(theta))
    y -= radius * (cos(theta + turn) - cos(theta))
    return x, y, wrap(theta + turn)

def project(u, v, camera):
    tilt = camera.tilt * pi / 180
    a = (u - camera.u0) / camera.focal
    b = (v - camera.v0) / camera.focal
    ahead, fall = cos(tilt) - b * sin(tilt), sin(tilt) + b * cos(tilt)
    if fall <= 0:
        return 0.0, inf
    x = camera.height * ahead / fall + camera.forward
    y = -camera.height * a / fall
    return atan2(y, x), sqrt(x * x + y * y)

def log_weight(poses, bearings, ranges, field, sigma):
    weights = []
    for px, py, theta in poses:
        total = 0.0
        for bearing, far in zip(bearings, ranges):
            if isinf(far):
                continue
            x = px + far * cos(theta + bearing)
            y = py + far * sin(theta + bearing)
            column = int((x - field.origin[0]) // field.cell)
            row = int((y - field.origin[1]) // field.cell)
            column = min(max(column, 0), len(field.distances[0]) - 1)
            row = min(max(row, 0), len(field.distances) - 1)
            away = field.distances[row][column]
            total += log(0.95 * exp(-0.5 * (away / sigma) ** 2) + 0.05)
        weights.append(total)
    return weights

def motion(poses, moved, alphas, rng):
    dx, dy, turn = moved
    a1, a2, a3, a4 = alphas
    way = hypot(dx, dy)
    rot1 = atan2(dy, dx)
    if dx < 0:
        way, rot1 = -way, atan2(-dy, -dx)
    rot2 = wrap(turn - rot1)
    result = []
    for x, y, theta in poses:
        w = way + rng.normal(0, sqrt(a3 * way * way + a4 * (rot1 * rot1 + rot2 * rot2)))
        r1 = rot1 + rng.normal(0, sqrt(a1 * rot1 * rot1 + a2 * way * way))
        r2 = rot2 + rng.normal(0, sqrt(a1 * rot2 * rot2 + a2 * way * way))
        result.append([x + w * cos(theta + r1), y + w * sin(theta + r1), wrap(theta + r1 + r2)])
    return result

def resample(poses, weights, rng):
    n = len(weights)
    start = rng.random() / n
    result = []
    i, total = 0, weights[0]
    for m in range(n):
        while total < start + m / n and i < n - 1:
            i += 1
            total += weights[i]
        result.append(list(poses[i]))
    return result, [1 / n] * n

def loop(poses, weights, moved, scan, parts):
    if hypot(moved[0], moved[1]) < 0.001 and abs(moved[2]) < 0.01:
        return poses, weights
    poses = parts.motion(poses, moved)
    fits = parts.log_weight(poses, scan)
    best = max(fits)
    weights = [w * exp(f - best) for w, f in zip(weights, fits)]
    total = sum(weights)
    weights = [w / total for w in weights]
    if 1 / sum(w * w for w in weights) < 0.5 * len(poses):
        return parts.resample(poses, weights)
    return poses, weights

def init(extent, count, rng):
    x0, y0, x1, y1 = extent
    return [[rng.uniform(x0, x1), rng.uniform(y0, y1), rng.uniform(-pi, pi)] for _ in range(count)]

def estimate(poses, weights):
    bx, by, btheta = poses[list(weights).index(max(weights))]
    x = y = c = s = total = 0.0
    for (px, py, theta), w in zip(poses, weights):
        if hypot(px - bx, py - by) < 0.1 and abs(wrap(theta - btheta)) < 0.5:
            x, y, total = x + w * px, y + w * py, total + w
            c, s = c + w * cos(theta), s + w * sin(theta)
    return x / total, y / total, atan2(s, c)

def inject(poses, fit, memory, anywhere, rng):
    memory.slow = memory.slow + 0.05 * (fit - memory.slow)
    memory.fast = memory.fast + 0.5 * (fit - memory.fast)
    share = 1 - memory.fast / memory.slow
    result = []
    for pose in poses:
        result.append(anywhere(1)[0] if rng.random() < share else pose.copy())
    return result
"""

MATRICES = """
import numpy as np

def rotation(theta):
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s], [s, c]])

def wrapped(angle):
    return np.angle(np.exp(1j * np.asarray(angle)))

def odometry(pose, left, right, track):
    turn = (right - left) / track
    step = np.array([0.5 * (left + right), 0.0])
    place = pose[:2] + rotation(pose[2] + 0.5 * turn) @ step
    return np.append(place, wrapped(pose[2] + turn))

def project(u, v, camera):
    t = np.deg2rad(camera.tilt)
    ray = np.array([(u - camera.u0) / camera.focal, (v - camera.v0) / camera.focal, 1.0])
    to_robot = np.array([[0, -np.sin(t), np.cos(t)], [-1, 0, 0], [0, -np.cos(t), -np.sin(t)]])
    toward = to_robot @ ray
    if toward[2] >= 0:
        return 0.0, np.inf
    point = np.array([camera.forward, 0.0, camera.height]) - toward * camera.height / toward[2]
    return np.arctan2(point[1], point[0]), np.linalg.norm(point[:2])

def log_weight(poses, bearings, ranges, field, sigma):
    good = ranges < np.inf
    local = (ranges * np.exp(1j * bearings))[good]
    result = np.zeros(len(poses))
    for k, (x, y, theta) in enumerate(poses):
        ends = x + 1j * y + np.exp(1j * theta) * local
        j = np.floor((ends.real - field.origin[0]) / field.cell).astype(int)
        i = np.floor((ends.imag - field.origin[1]) / field.cell).astype(int)
        i, j = (np.clip(at, 0, size - 1) for at, size in zip((i, j), field.distances.shape))
        d2 = np.square(field.distances[i, j])
        result[k] = np.sum(np.log(0.05 + 0.95 * np.exp(-d2 / 2 / sigma**2)))
    return result

def motion(poses, moved, alphas, rng):
    back = moved[0] < 0
    step = complex(moved[0], moved[1])
    way, rot1 = (-abs(step), np.angle(-step)) if back else (abs(step), np.angle(step))
    rot2 = wrapped(moved[2] - rot1)
    sd = np.sqrt([
        alphas[2] * way**2 + alphas[3] * (rot1**2 + rot2**2),
        alphas[0] * rot1**2 + alphas[1] * way**2,
        alphas[0] * rot2**2 + alphas[1] * way**2,
    ])
    noisy = np.array([way, rot1, rot2]) + sd * rng.standard_normal((len(poses), 3))
    toward = noisy[:, 0] * np.exp(1j * (poses[:, 2] + noisy[:, 1]))
    theta = wrapped(poses[:, 2] + noisy[:, 1] + noisy[:, 2])
    return np.stack([poses[:, 0] + toward.real, poses[:, 1] + toward.imag, theta], axis=1)

def resample(poses, weights, rng):
    n = len(poses)
    drawn = rng.choice(n, size=n, p=weights)
    return poses[drawn].copy(), np.ones(n) / n

def loop(poses, weights, moved, scan, parts):
    still = np.hypot(*moved[:2]) < 1e-3 and np.abs(moved[2]) < 1e-2
    if still:
        return poses, weights
    moved_poses = parts.motion(poses, moved)
    with np.errstate(divide="ignore"):
        logs = np.log(weights) + parts.log_weight(moved_poses, scan)
    new = np.exp(logs - logs.max())
    new = new / new.sum()
    effective = 1.0 / np.dot(new, new)
    return parts.resample(moved_poses, new) if effective < len(new) / 2 else (moved_poses, new)

def init(extent, count, rng):
    low = np.array([extent[0], extent[1], -np.pi])
    high = np.array([extent[2], extent[3], np.pi])
    return low + (high - low) * rng.random((count, 3))

def estimate(poses, weights):
    best = poses[np.argmax(weights)]
    near = np.linalg.norm(poses[:, :2] - best[:2], axis=1) < 0.1
    near &= np.abs(wrapped(poses[:, 2] - best[2])) < 0.5
    w = weights[near] / weights[near].sum()
    mean = np.average(poses[near, :2], axis=0, weights=w)
    return np.append(mean, np.angle(np.sum(w * np.exp(1j * poses[near, 2]))))

def inject(poses, fit, memory, anywhere, rng):
    memory.slow = 0.95 * memory.slow + 0.05 * fit
    memory.fast = 0.5 * memory.fast + 0.5 * fit
    share = np.clip(1 - memory.fast / memory.slow, 0, 1)
    chosen = rng.permutation(len(poses))[: int(round(share * len(poses)))]
    new = np.array(poses)
    new[chosen] = anywhere(len(chosen))
    return new
"""

KALMAN = """
def kalman(mean, sd, moved, moved_sd, seen, seen_sd):
    mean, variance = mean + moved, sd**2 + moved_sd**2
    k = variance / (variance + seen_sd**2)
    return mean + k * (seen - mean), math.sqrt((1 - k) * variance)
"""

BASES = {"arrays": ARRAYS, "loops": LOOPS, "matrices": MATRICES}
