"""The program: engine, server, views and command line."""
