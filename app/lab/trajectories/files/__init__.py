"""Files of trajectories: TUM text, tables with a header, Motive's CSV and MRCLAM."""
