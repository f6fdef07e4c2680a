"""Control in a process of its own: robot, scanner, filter and engine, apart from who looks on."""
