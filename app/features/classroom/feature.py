"""What the classroom adds: a hub for a class, and the server of one student in it."""

from app.feature import Feature, Late, Subcommand

FEATURE = Feature(
    name="classroom",
    about="a class of students, each with a robot of their own, by JupyterHub",
    subcommands=(
        Subcommand(
            "class",
            "serve a class: a robot and a link for each student, by JupyterHub",
            Late("app.features.classroom.options:add_class"),
        ),
        Subcommand(
            "single-user",
            "serve one student's robot, as JupyterHub starts it",
            Late("app.features.classroom.options:add_single_user"),
        ),
        Subcommand(
            "shared-robot",
            "serve one robot to a class, by turns, as JupyterHub starts it",
            Late("app.features.classroom.options:add_shared_robot"),
        ),
    ),
)
