"""What the kept pose adds: the next run may start where the last one on the same field ended."""

from app.feature import Feature, Late, SettingOption

FEATURE = Feature(
    name="kept_pose",
    about="keeps the pose in a file, so that the next run can start where this one ended",
    run_options=(
        SettingOption("start_pose.restore_pose"),
        SettingOption("start_pose.pose_file", metavar="FILE"),
    ),
    starts=(Late("app.features.kept_pose.keeping:kept_start"),),
    outlet=Late("app.features.kept_pose.keeping:PoseKeeper"),
)
