"""The robot: its description, hardware, driving, cameras, scans, fields and localization."""
