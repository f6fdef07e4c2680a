"""The robot: its description, hardware, driving, cameras, scans, fields and localization."""

from robot.compiled_code import set_compile_cache

set_compile_cache()
