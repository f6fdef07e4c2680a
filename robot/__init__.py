"""What a robot is, knows and can do."""

from robot.compiled_code import keep_compiled_code

keep_compiled_code()
