"""The lens's calibration on the page."""
