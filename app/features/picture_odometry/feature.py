"""What motion from the picture adds: it tests the wheels, may aid odometry, and shows the floor."""

from pathlib import Path

from app.feature import Feature, Late, Panel
from app.languages.marking import phrase

PAGE = Path(__file__).parent / "page"
FEATURE = Feature(
    name="picture_odometry",
    about="sees in pictures how the floor moves, and tests the wheels by it",
    settings=Late("robot.picture_odometry.settings:PictureOdometrySettings"),
    companions=(Late("app.features.picture_odometry.beginning:companions"),),
    compiled=(Late("app.features.picture_odometry.compiled:COMPILED"),),
    values=(Late("app.features.picture_odometry.values:VALUES"),),
    routers=(Late("app.features.picture_odometry.routes:floor_router"),),
    topics=(Late("app.features.picture_odometry.topics:TOPICS"),),
    panels=(Panel("floor", phrase("Floor"), PAGE / "floor_panel.js"),),
)
