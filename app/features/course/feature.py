"""What the course adds: lessons beside the dashboard, and a grader that names the cause."""

from app.feature import Feature, Late, Subcommand

FEATURE = Feature(
    name="course",
    about="lessons beside the dashboard, and a grader that names the cause of a mistake",
    subcommands=(
        Subcommand(
            "learn",
            "the course: lessons beside the dashboard",
            Late("app.features.course.options:add_learn"),
        ),
        Subcommand(
            "check",
            "say what is wrong with a lesson's code",
            Late("app.features.course.options:add_check"),
        ),
    ),
    checks=(Late("app.features.course.doctor_check:check_student_files"),),
)
