"""The emulated Build HAT as a program: a serial port, real time, wheels with forces, pictures."""
