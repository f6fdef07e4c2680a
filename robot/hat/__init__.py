"""The Build HAT: its language, its port and the joints that it drives."""
