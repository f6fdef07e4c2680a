"""Thresholds that server and page share: messages tell them to the page, or their results."""

STALE_S = 2.0
"""After this time without a tick [s], what was published last does not show the present."""

LONGEST_STEP_M = 0.1
"""A longer step of a path [m] was not driven: the robot or the estimate was put elsewhere."""

LIKELY = 0.02
"""Hypotheses of less weight are not drawn."""

ALIKE = 0.5
"""A place with at least this share of the heaviest weight looks like the heaviest place."""
