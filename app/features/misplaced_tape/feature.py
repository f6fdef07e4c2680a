"""What misplaced tape adds: it is named, and left out of scans, so that the robot is not lost."""

from app.feature import Feature, Late

FEATURE = Feature(
    name="misplaced_tape",
    about="names tape that does not lie where the drawing has it, and does without it",
    compiled=(Late("app.features.misplaced_tape.compiled:COMPILED"),),
    models=(Late("app.features.misplaced_tape.laid_watch:tape_watches"),),
    companions=(Late("app.features.misplaced_tape.watch:tape_companion"),),
    outlet=Late("app.features.misplaced_tape.outlet:MisplacedTapeOutlet"),
)
