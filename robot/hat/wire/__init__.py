"""How bytes pass a serial port, by this operating system's means."""
