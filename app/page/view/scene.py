"""The scene of the 3D view: floor, robot, particles, rays and paths, drawn by viser.

The view has no controls; these are on our own page. Nodes are made once, and only their arrays are
replaced: that costs the server a millisecond, whatever the number of viewers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

import cv2
import numpy as np
import viser

from app.engine.snapshot import Snapshot
from app.page.shown_floor import shown_floor
from app.page.thresholds import LIKELY
from app.page.view.camera_layer import CameraLayer
from app.page.view.marks import ESTIMATE, arrow, by_weight, hypothesis_mark, lifted, quaternions
from app.page.view.paths import Path
from app.page.view.robot_mesh import robot_meshes
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.scanning.line_scanner import LineScan

TRUTH, ODOMETRY = (0, 105, 79), (168, 50, 4)
RAY, HIT = (168, 98, 0), (176, 16, 107)
"""As the page's map has them: --floor-truth and its neighbours in style/tokens.css."""
PICTURE_TICKS = 3
"""The picture is renewed once in this many updates: five times a second."""
HEADINGS = 150
"""About this many particles are drawn with their heading."""
FAR_AWAY = -100.0
"""Coordinate of things that must not be visible [m]."""
LARGEST_FLOOR_PX = 1536
"""Longer side of the floor's texture: larger ones take a viewer long to load."""
RAY_STEP = 3
"""One of this many rays is drawn: all of them would hide the floor."""
LABEL_HEIGHT = {"truth": 0.24, "odometry": 0.06, "estimate": 0.15}
"""Heights of the labels above the floor [m]."""
LIFT = {"paths": 0.002, "rays": 0.003, "particles": 0.004, "headings": 0.005, "estimate": 0.006}
"""Heights above the floor [m]; they differ, so that layers do not flicker through each other."""


class ViewLayer(Protocol):
    """What a feature adds to the scene."""

    def update(self) -> None:
        """Show what there is now; called three times a second, while somebody looks."""
        ...


NewViewLayer = Callable[[viser.SceneApi], ViewLayer]
"""Adds a layer's nodes to a scene."""


class Scene:
    """The scene of one viser server."""

    def __init__(
        self,
        server: viser.ViserServer,
        field: Field,
        spec: RobotSpec,
        layers: Iterable[NewViewLayer],
        paths: Mapping[str, Path],
    ) -> None:
        self._server = server
        self._paths = paths
        self._ticks = 0
        self._layers: frozenset[str] | None = None
        self._shown: LineScan | None = None
        scene = server.scene
        scene.set_up_direction("+z")
        # viser's own light is an environment that a browser without a graphics card computes for
        # eight seconds, in which the page's connections break.
        scene.configure_environment_map(hdri=None)
        scene.configure_default_lights(cast_shadow=False)
        scene.add_light_hemisphere("/light", intensity=2.0)
        self._floor(field)
        self._robot = scene.add_frame("/robot", show_axes=False)
        self._spec = spec
        self._parts = [
            scene.add_mesh_simple(
                f"/robot/{number}", mesh.vertices, mesh.faces, color=colour, flat_shading=True
            )
            for number, (colour, mesh) in enumerate(robot_meshes(spec.urdf).items())
        ]
        # What the robot believes and sees moves with it: it is one node that moves, in the same
        # moment as the robot's body, and not many that a viewer draws one after the other.
        self._believed = scene.add_frame("/believed", show_axes=False)
        self._nodes = self._add_nodes(scene)
        self._camera = CameraLayer(scene, spec, field.floor)
        self._show_outline()
        self._added = [make(scene) for make in layers]

    def update(self, snapshot: Snapshot) -> None:
        """Show a snapshot."""
        self._ticks += 1
        if snapshot.spec is not self._spec:
            self._change_robot(snapshot.spec)
        with self._server.atomic():
            self._show_layers(snapshot)
            self._show_robot(snapshot)
            # A new measurement only comes with a new picture.
            if self._shown is not snapshot.filter.line_scan:
                self._shown = snapshot.filter.line_scan
                self._show_cloud(snapshot)
                self._show_scan(snapshot)
            if self._ticks % PICTURE_TICKS == 0 and "camera" in snapshot.layers:
                self._camera.picture(snapshot)
            if self._ticks % 5 == 0:
                self._show_paths()
                for layer in self._added:
                    layer.update()
        self._server.flush()

    def _change_robot(self, spec: RobotSpec) -> None:
        """Show the robot as a calibration knows it: the same parts, a little elsewhere."""
        self._spec = spec
        for part, mesh in zip(self._parts, robot_meshes(spec.urdf).values(), strict=True):
            part.vertices, part.faces = mesh.vertices.astype(np.float32), mesh.faces
        self._show_outline()
        self._camera.use_robot(spec)

    def _floor(self, field: Field) -> None:
        xmin, ymin, xmax, ymax = field.floor.extent
        shrink = min(1.0, LARGEST_FLOOR_PX / max(field.floor.image.shape))
        grey = cv2.resize(
            shown_floor(field), None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA
        )
        self._server.scene.add_image(
            "/floor",
            np.repeat(grey[:, :, None], 3, axis=2),
            xmax - xmin,
            ymax - ymin,
            format="jpeg",
            jpeg_quality=85,
            cast_shadow=False,
            receive_shadow=False,
            # viser's pictures lie with their rows along +y; the floor's run along -y.
            wxyz=(0.0, 1.0, 0.0, 0.0),
            position=((xmin + xmax) / 2, (ymin + ymax) / 2, -0.001),
        )

    def _add_nodes(self, scene: viser.SceneApi) -> dict[str, Any]:
        nothing = np.zeros((1, 2, 3))
        point = np.zeros((1, 3))

        def lines(name: str, colour: tuple[int, int, int], width: float) -> Any:
            return scene.add_line_segments(
                name, nothing, colour, thickness=width, thickness_units="world"
            )

        return {
            "particles": scene.add_point_cloud(
                "/particles", point, ESTIMATE, point_size=0.004, point_shape="circle",
                point_shading="flat",
            ),
            "headings": scene.add_batched_meshes_simple(
                "/headings", *arrow(), np.array([[1.0, 0, 0, 0]]), point,
                batched_colors=ESTIMATE, lod="off", side="double", cast_shadow=False,
                receive_shadow=False,
            ),
            "rays": lines("/believed/rays", RAY, 0.0012),
            "hits": scene.add_point_cloud(
                "/believed/hits", point, HIT, point_size=0.009, point_shape="circle",
                point_shading="flat",
            ),
            "covariance": lines("/covariance", ESTIMATE, 0.003),
            "estimate": lines("/believed/estimate", ESTIMATE, 0.004),
            "path_truth": lines("/path_truth", TRUTH, 0.005),
            "path_odometry": lines("/path_odometry", ODOMETRY, 0.004),
            "path_estimate": lines("/path_estimate", ESTIMATE, 0.003),
            "label_truth": scene.add_label("/label_truth", "truth", font_screen_scale=0.8),
            "label_odometry": scene.add_label("/label_odometry", "odometry", font_screen_scale=0.8),
            "label_estimate": scene.add_label("/label_estimate", "estimate", font_screen_scale=0.8),
        }  # fmt: skip

    def _show_layers(self, snapshot: Snapshot) -> None:
        if snapshot.layers == self._layers:
            return
        self._layers = snapshot.layers
        truth = "truth" in snapshot.layers and snapshot.truth is not None
        paths = "paths" in snapshot.layers
        visible = {
            "hits": "rays" in snapshot.layers,
            "estimate": True,
            "path_truth": paths and truth,
            "path_odometry": paths,
            "path_estimate": paths,
            "label_truth": truth,
            "label_odometry": paths,
            "label_estimate": True,
        }
        for name, node in self._nodes.items():
            node.visible = visible.get(name, name in snapshot.layers)
        self._camera.show("camera" in snapshot.layers)

    def _show_robot(self, snapshot: Snapshot) -> None:
        believed = snapshot.pose or snapshot.odometry
        show_truth = snapshot.truth is not None and "truth" in snapshot.layers
        where = snapshot.truth if show_truth and snapshot.truth else believed
        self._robot.position = (where.x, where.y, 0.0)
        self._robot.wxyz = tuple(quaternions(np.array([where.theta]))[0])
        if snapshot.pose is not None:
            self._believed.position = (snapshot.pose.x, snapshot.pose.y, 0.0)
            self._believed.wxyz = tuple(quaternions(np.array([snapshot.pose.theta]))[0])
            self._camera.place(snapshot)
        else:
            self._believed.position = (0.0, 0.0, FAR_AWAY)
            self._nodes["label_estimate"].position = (0.0, 0.0, FAR_AWAY)
        if self._ticks % 5 == 0:
            for name, pose in (
                ("truth", snapshot.truth),
                ("odometry", snapshot.odometry),
                ("estimate", snapshot.pose),
            ):
                if pose is not None:
                    self._nodes[f"label_{name}"].position = (pose.x, pose.y, LABEL_HEIGHT[name])

    def _show_cloud(self, snapshot: Snapshot) -> None:
        poses, weights = snapshot.filter.cloud.poses, snapshot.filter.cloud.weights
        if not len(poses):
            # A filter that knows nothing has no particles; viser does not redraw empty nodes.
            poses, weights = np.full((1, 3), FAR_AWAY), np.ones(1)
        particles = self._nodes["particles"]
        particles.points = lifted(poses[:, :2], LIFT["particles"]).astype(np.float32)
        particles.colors = by_weight(weights)
        few = poses[:: max(1, len(poses) // HEADINGS)]
        headings = self._nodes["headings"]
        headings.batched_positions = lifted(few[:, :2], LIFT["headings"])
        headings.batched_wxyzs = quaternions(few[:, 2])
        self._show_hypotheses(snapshot)

    def _show_hypotheses(self, snapshot: Snapshot) -> None:
        """An ellipse for each place where the robot may be, the likeliest with full colour."""
        result = snapshot.estimate.hypotheses if snapshot.estimate is not None else ()
        shown = [hypothesis for hypothesis in result if hypothesis.weight >= LIKELY]
        node = self._nodes["covariance"]
        if not shown:
            node.points = np.full((1, 2, 3), FAR_AWAY)
            node.colors = np.zeros((1, 2, 3), dtype=np.uint8)
            return
        marks = [hypothesis_mark(each.pose, each.covariance) for each in shown]
        node.points = lifted(np.concatenate(marks), LIFT["estimate"])
        parts = np.repeat([item.weight for item in shown], [len(mark) for mark in marks])
        node.colors = np.repeat(by_weight(parts)[:, None, :], 2, axis=1)

    def _show_scan(self, snapshot: Snapshot) -> None:
        if snapshot.filter.line_scan is None or snapshot.scan_pose is None or snapshot.pose is None:
            # The start of the rays is not known.
            self._nodes["rays"].points = np.full((1, 2, 3), FAR_AWAY)
            self._nodes["hits"].points = np.full((1, 3), FAR_AWAY, dtype=np.float32)
            return
        scan = snapshot.filter.line_scan.scan
        # As seen from where the robot is now: it has moved on since the picture.
        now_from_scan = snapshot.pose.inverse() @ snapshot.scan_pose
        start = now_from_scan @ scan.robot_from_scan
        ends = now_from_scan.apply(scan.points())
        if len(ends) == 0:
            ends = np.array([[start.x, start.y]])
        starts = np.broadcast_to((start.x, start.y), ends.shape)
        rays = np.stack([starts, ends], axis=1)[::RAY_STEP]
        self._nodes["rays"].points = lifted(rays, LIFT["rays"])
        self._nodes["hits"].points = lifted(ends, LIFT["rays"]).astype(np.float32)

    def _show_outline(self) -> None:
        corners = self._spec.outline
        outline = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
        self._nodes["estimate"].points = lifted(outline, LIFT["estimate"])

    def _show_paths(self) -> None:
        for name, path in self._paths.items():
            segments = path.segments(every=2 if name == "odometry" else 1)
            if len(segments):
                self._nodes[f"path_{name}"].points = lifted(segments, LIFT["paths"])
