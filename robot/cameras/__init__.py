"""Real cameras, recorded pictures and the emulator's camera, all behind one protocol."""
