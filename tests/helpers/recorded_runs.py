"""Trajectories as other programs write them, and what ``brickpose evaluate`` says of them."""

import json
import math

import numpy as np

from app.command_line import main
from app.trajectories.trajectory import Trajectory


def eight(offset=0.0, noise=0.0, rate=30.0, seconds=32.0, seed=0):
    """A robot on the figure-eight, as a trajectory whose clock is off."""
    stamps = np.arange(0, seconds, 1 / rate)
    turn = np.where(stamps % 15.9 < 7.96, 0.79, -0.79)
    theta = np.concatenate([[0], np.cumsum(turn[:-1]) / rate])
    middle = theta + turn / rate / 2
    way = 0.15 / rate * np.stack([np.cos(middle), np.sin(middle)], 1)
    xy = np.concatenate([[[0, 0]], np.cumsum(way, 0)[:-1]])
    xy += np.random.default_rng(seed).normal(0, noise, xy.shape)
    return Trajectory.of_poses(stamps + offset, np.column_stack([xy, theta]))


def motive(path, trajectory, bodies=("robot",)):
    """As Motive writes it: y up, quaternions, seconds since the take began."""
    rows = ["Format Version,1.23,Take Name,t,Rotation Type,Quaternion,Length Units,Meters"]
    kinds = ["Rotation"] * 4 + ["Position"] * 3
    columns = [(body, kind) for body in bodies for kind in kinds]
    rows += ["", ",Type" + ",Rigid Body" * len(columns)]
    rows += [",Name" + "".join(f",{body}" for body, _ in columns)]
    rows += [",ID" + ",1" * len(columns), "," + "".join(f",{kind}" for _, kind in columns)]
    rows += ["Frame,Time (Seconds)" + ",X,Y,Z,W,X,Y,Z" * len(bodies)]
    since = trajectory.stamps - trajectory.stamps[0]
    for n, (t, (x, y, theta)) in enumerate(zip(since, trajectory.poses, strict=True)):
        half = theta / 2
        one = f",0,{math.sin(half):.9f},0,{math.cos(half):.9f},{x:.7f},0.1,{-y:.7f}"
        rows.append(f"{n},{t:.6f}" + one * len(bodies))
    path.write_text("\n".join(rows) + "\n")


def evaluate(tmp_path, *more):
    out = tmp_path / "out"
    given = ["--recording", str(tmp_path / "estimate.tum"), "--out", str(out)]
    code = main(["evaluate", *given, *more])
    return code, json.loads((out / "results.json").read_text()) if not code else None


def mean(results, name="ate_rmse_m"):
    return results["methods"]["amcl"][name]["mean"]
