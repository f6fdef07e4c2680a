"""Maps: the tape of a floor, drawn from what a robot saw while it drove (SLAM)."""
