"""scan, map and the camera's topics: what the robot sees and what it knows of the field."""

from __future__ import annotations

import cv2
import numpy as np

from app.engine.snapshot import Snapshot
from app.features.ros.encoding.frames import header, pose, time
from app.features.ros.message_types import Message, new
from app.features.ros.source import UNCHANGING, TopicSource


def scan_stamp(snapshot: Snapshot) -> float | None:
    """Stamp of the last scanned picture (its exposure); None before the first one."""
    return snapshot.filter.line_scan.scan.stamp if snapshot.filter.line_scan else None


def laser_scan(source: TopicSource, snapshot: Snapshot) -> Message:
    """The distances to tape, as a laser would measure them; no return is +inf (REP-117)."""
    assert snapshot.filter.line_scan is not None  # otherwise the stamp is None
    scan = snapshot.filter.line_scan.scan
    bearings = scan.bearings
    return new(
        "sensor_msgs/msg/LaserScan",
        header=header(source, scan.stamp, source.settings.scan_frame_id),
        angle_min=float(bearings[0]),
        angle_max=float(bearings[-1]),
        angle_increment=float((bearings[-1] - bearings[0]) / max(1, len(bearings) - 1)),
        time_increment=0.0,
        scan_time=0.0,
        range_min=source.robot(snapshot).range_min,
        range_max=float(source.robot(snapshot).scanner.settings.range_max),
        ranges=scan.ranges.astype(np.float32),
        intensities=np.empty(0, dtype=np.float32),
    )


def map_stamp(snapshot: Snapshot) -> float:
    """When the map was drawn that is drawn by driving; the field's never changes."""
    return UNCHANGING if snapshot.drawn is None else snapshot.drawn.stamp


def occupancy_grid(source: TopicSource, snapshot: Snapshot) -> Message:
    """The map that is drawn by driving, else the field, as nav_msgs/OccupancyGrid.

    Tape is occupied; of a map that is drawn, floor that nobody looked at is unknown.
    """
    if snapshot.drawn is not None:
        grid = snapshot.drawn.grid
    else:
        grid = source.field.grid or source.field.occupancy(source.settings.map_resolution)
    height, width = grid.data.shape
    return new(
        "nav_msgs/msg/OccupancyGrid",
        header=header(source, snapshot.stamp, source.settings.global_frame_id),
        info=new(
            "nav_msgs/msg/MapMetaData",
            map_load_time=time(source.clock.ns(0.0)),
            resolution=float(grid.resolution),
            width=width,
            height=height,
            origin=pose(grid.origin),
        ),
        data=grid.data.ravel(),
    )


def picture_stamp(snapshot: Snapshot) -> float | None:
    """Stamp of the picture of this tick (its exposure); None without a picture."""
    return snapshot.reading.frame.stamp if snapshot.reading.frame else None


def compressed_image(source: TopicSource, snapshot: Snapshot) -> Message:
    """The picture as JPEG."""
    frame = snapshot.reading.frame
    assert frame is not None  # otherwise the stamp is None
    quality = [cv2.IMWRITE_JPEG_QUALITY, source.settings.jpeg_quality]
    fine, data = cv2.imencode(".jpg", frame.image, quality)
    if not fine:
        raise ValueError(f"a picture of shape {frame.image.shape} cannot be made a JPEG")
    coding = "mono8" if frame.image.ndim == 2 else "bgr8"
    return new(
        "sensor_msgs/msg/CompressedImage",
        header=header(source, frame.stamp, source.robot(snapshot).links.camera),
        # As image_transport writes it: the encoding of the picture, and of the compressed data.
        format=f"{coding}; jpeg compressed {coding}",
        data=np.asarray(data).ravel(),
    )


def camera_info(source: TopicSource, snapshot: Snapshot) -> Message:
    """The lens parameters, with the stamp of the picture."""
    frame = snapshot.reading.frame
    assert frame is not None  # otherwise the stamp is None
    lens = source.robot(snapshot).spec.lens
    return new(
        "sensor_msgs/msg/CameraInfo",
        header=header(source, frame.stamp, source.robot(snapshot).links.camera),
        height=lens.height,
        width=lens.width,
        distortion_model=lens.model,
        d=lens.distortion,
        k=lens.matrix.ravel(),
        r=np.eye(3).ravel(),
        p=np.column_stack([lens.matrix, np.zeros(3)]).ravel(),
        binning_x=0,
        binning_y=0,
        roi=new(
            "sensor_msgs/msg/RegionOfInterest",
            x_offset=0,
            y_offset=0,
            height=0,
            width=0,
            do_rectify=False,
        ),
    )
