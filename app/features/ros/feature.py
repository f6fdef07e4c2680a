"""What ROS adds: topics, services and parameters by rosbridge, Foxglove, DDS; maps, exports."""

from app.feature import Feature, Late, SettingOption, Subcommand

FEATURE = Feature(
    name="ros",
    about="the robot as ROS 2 sees it: rosbridge, Foxglove, DDS, maps, and files for Nav2",
    subcommands=(
        Subcommand(
            "export",
            "files for other programs: ROS 2",
            Late("app.features.ros.export.options:add_export"),
        ),
    ),
    run_options=(SettingOption("ros2.dds", name="ros2"), SettingOption("ros2.foxglove")),
    guests=(Late("app.features.ros.guests:guests"),),
    outlet=Late("app.features.ros.outlet:RosOutlet"),
    fields=(Late("app.features.ros.map_fields:FIELDS"),),
    checks=(Late("app.features.ros.doctor_check:check_topics"),),
)
