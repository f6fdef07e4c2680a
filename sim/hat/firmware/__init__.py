"""Parts of the emulated Build HAT's firmware: ports, controllers, reports and power."""
