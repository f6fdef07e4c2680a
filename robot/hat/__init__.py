"""The Build HAT: its protocol, its port and the joints that it drives."""
