"""A warm process, of which students' servers are copies."""
