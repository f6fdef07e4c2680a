"""The emulated Build HAT as a program: serial port, real time, wheels with forces, pictures."""
