"""Files of trajectories: TUM text, Motive's CSV, MRCLAM."""
