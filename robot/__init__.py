"""The robot: its description, hardware, driving, cameras, scans, fields and localization."""

from robot.compiled_code import keep_compiled_code

keep_compiled_code()
