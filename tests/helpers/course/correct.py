# ruff: noqa: E501 - pieces of code are not broken
"""Ten styles of correct solutions: no one of them may be complained about."""

from course.solutions import ARRAYS, LOOPS, MATRICES

NUMBA = """
import numba

@numba.njit
def log_weight(poses, bearings, ranges, distances, left, bottom, cell, sigma):
    result = np.zeros(len(poses))
    for k in range(len(poses)):
        for m in range(len(ranges)):
            if np.isfinite(ranges[m]):
                angle = poses[k, 2] + bearings[m]
                x = poses[k, 0] + ranges[m] * np.cos(angle)
                y = poses[k, 1] + ranges[m] * np.sin(angle)
                row = min(max(int((y - bottom) / cell), 0), len(distances) - 1)
                column = min(max(int((x - left) / cell), 0), len(distances[0]) - 1)
                d = distances[row, column]
                result[k] += np.log(0.95 * np.exp(-d * d / (2 * sigma * sigma)) + 0.05)
    return result

compiled = log_weight

def log_weight(poses, bearings, ranges, field, sigma):
    left, bottom = field.origin
    return compiled(poses, bearings, ranges, field.distances, left, bottom, field.cell, sigma)

@numba.njit
def odometry(pose, left, right, track):
    turn = (right - left) / track
    middle = pose[2] + turn / 2
    way = (left + right) / 2
    theta = (pose[2] + turn + np.pi) % (2 * np.pi) - np.pi
    return np.array([pose[0] + way * np.cos(middle), pose[1] + way * np.sin(middle), theta])
"""

STRATIFIED = """
def resample(poses, weights, rng):
    n = len(weights)
    places = (rng.random(n) + np.arange(n)) / n
    drawn = np.minimum(np.searchsorted(np.cumsum(weights), places), n - 1)
    return np.take(poses, drawn, axis=0), np.repeat(1 / n, n)

def estimate(poses, weights):
    best = poses[weights.argmax()]
    turn = np.arctan2(np.sin(poses[:, 2] - best[2]), np.cos(poses[:, 2] - best[2]))
    near = (((poses - best)[:, :2] ** 2).sum(axis=1) < 0.01) & (abs(turn) < 0.5)
    w, p = weights[near], poses[near]
    c, s = (w * np.cos(p[:, 2])).sum(), (w * np.sin(p[:, 2])).sum()
    return (w * p[:, 0]).sum() / w.sum(), (w * p[:, 1]).sum() / w.sum(), np.arctan2(s, c)
"""

RESIDUAL = """
def resample(poses, weights, rng):
    n = len(weights)
    sure = np.floor(n * weights + 1e-12).astype(int)
    rest = n * weights - sure
    drawn = np.repeat(np.arange(n), sure)
    left = n - len(drawn)
    if left > 0:
        more = rng.choice(n, left, p=np.maximum(rest, 0) / np.maximum(rest, 0).sum())
        drawn = np.concatenate([drawn, more])
    return poses[drawn], np.full(n, 1.0 / n)

def inject(poses, fit, memory, anywhere, rng):
    memory.slow += (fit - memory.slow) / 20
    memory.fast += (fit - memory.fast) / 2
    if memory.fast >= memory.slow:
        return poses.copy()
    count = rng.binomial(len(poses), 1 - memory.fast / memory.slow)
    result = poses.copy()
    if count:
        result[rng.choice(len(poses), count, replace=False)] = anywhere(count)
    return result
"""

LOGARITHMS = """
def log_weight(poses, bearings, ranges, field, sigma):
    keep = np.flatnonzero(np.isfinite(ranges))
    angle = np.add.outer(poses[:, 2], bearings[keep])
    x = poses[:, 0, None] + np.cos(angle) * ranges[keep]
    y = poses[:, 1, None] + np.sin(angle) * ranges[keep]
    j = ((x - field.origin[0]) // field.cell).astype(int)
    i = ((y - field.origin[1]) // field.cell).astype(int)
    i, j = np.clip(i, 0, field.distances.shape[0] - 1), np.clip(j, 0, field.distances.shape[1] - 1)
    fit = np.log(0.95) - 0.5 * (field.distances[i, j] / sigma) ** 2
    return np.logaddexp(fit, np.log(0.05)).sum(-1)

def loop(poses, weights, moved, scan, parts):
    if max(math.hypot(*moved[:2]) / 0.001, abs(moved[2]) / 0.01) < 1:
        return poses, weights
    poses = parts.motion(poses, moved)
    logs = np.log(weights) + parts.log_weight(poses, scan)
    weights = np.exp(logs - np.logaddexp.reduce(logs))
    if (weights**2).sum() > 2 / len(weights):
        return parts.resample(poses, weights)
    return poses, weights
"""

CHORDS = """
def odometry(pose, left, right, track):
    turn, way = (right - left) / track, (right + left) / 2
    chord = way * np.sinc(turn / 2 / np.pi)
    x = pose[0] + chord * np.cos(pose[2] + turn / 2)
    y = pose[1] + chord * np.sin(pose[2] + turn / 2)
    return (x, y, math.remainder(pose[2] + turn, 2 * math.pi))

def project(u, v, camera):
    below = math.radians(camera.tilt) + math.atan((v - camera.v0) / camera.focal)
    if below <= 0:
        return 0.0, math.inf
    ahead = camera.height / math.tan(below)
    slant = math.hypot(camera.height, ahead)
    depth = slant * math.cos(math.atan((v - camera.v0) / camera.focal))
    side = -(u - camera.u0) / camera.focal * depth
    return math.atan2(side, camera.forward + ahead), math.hypot(side, camera.forward + ahead)

def motion(poses, moved, alphas, rng):
    dx, dy, turn = moved
    a1, a2, a3, a4 = alphas
    way = math.hypot(dx, dy)
    rot1 = math.atan2(dy, dx) if way > 1e-9 else 0.0
    if abs(rot1) > math.pi / 2:
        way, rot1 = -way, math.remainder(rot1 + math.pi, 2 * math.pi)
    rot2 = math.remainder(turn - rot1, 2 * math.pi)
    new = np.array(poses)
    r1 = rng.normal(rot1, math.sqrt(a1 * rot1**2 + a2 * way**2), len(new))
    w = rng.normal(way, math.sqrt(a3 * way**2 + a4 * rot1**2 + a4 * rot2**2), len(new))
    r2 = rng.normal(rot2, math.sqrt(a1 * rot2**2 + a2 * way**2), len(new))
    new += np.stack([w * np.cos(new[:, 2] + r1), w * np.sin(new[:, 2] + r1), r1 + r2], axis=1)
    new[:, 2] = np.arctan2(np.sin(new[:, 2]), np.cos(new[:, 2]))
    return new
"""

OBJECTS = """
class Particle:
    def __init__(self, pose):
        self.x, self.y, self.theta = pose

    def moved(self, way, first, second):
        return Particle((
            self.x + way * math.cos(self.theta + first),
            self.y + way * math.sin(self.theta + first),
            math.atan2(math.sin(self.theta + first + second), math.cos(self.theta + first + second)),
        ))

    def pose(self):
        return [self.x, self.y, self.theta]

def motion(poses, moved, alphas, rng):
    sign = -1 if moved[0] < 0 else 1
    way = sign * math.hypot(moved[0], moved[1])
    first = math.atan2(sign * moved[1], sign * moved[0])
    second = moved[2] - first
    result = []
    for particle in map(Particle, poses):
        w = way + rng.standard_normal() * (alphas[2] * way**2 + alphas[3] * (first**2 + second**2)) ** 0.5
        r = first + rng.standard_normal() * (alphas[0] * first**2 + alphas[1] * way**2) ** 0.5
        s = second + rng.standard_normal() * (alphas[0] * second**2 + alphas[1] * way**2) ** 0.5
        result.append(particle.moved(w, r, s).pose())
    return np.array(result)
"""

COMPREHENSIONS = """
def resample(poses, weights, rng):
    bounds = np.cumsum(weights)
    chosen = [next((i for i, bound in enumerate(bounds) if u < bound), len(weights) - 1)
              for u in rng.random(len(weights))]
    return np.array([poses[i] for i in chosen]), np.array([1 / len(weights)] * len(weights))

def init(extent, count, rng):
    return np.column_stack([
        rng.uniform(extent[0], extent[2], count),
        rng.uniform(extent[1], extent[3], count),
        rng.uniform(-np.pi, np.pi, count),
    ])
"""

CORRECT = {
    "arrays": ARRAYS,
    "loops": LOOPS,
    "matrices": MATRICES,
    "numba": ARRAYS + NUMBA,
    "stratified": ARRAYS + STRATIFIED,
    "residual": ARRAYS + RESIDUAL,
    "logarithms": ARRAYS + LOGARITHMS,
    "chords": ARRAYS + CHORDS,
    "objects": ARRAYS + OBJECTS,
    "comprehensions": ARRAYS + COMPREHENSIONS,
}
