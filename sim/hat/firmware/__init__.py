"""What runs in the emulated Build HAT: ports, controllers, reports and its main loop."""
