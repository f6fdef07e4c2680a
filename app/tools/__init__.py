"""Programs besides the dashboard: doctor, emulated Build HAT, replays from the command line."""
