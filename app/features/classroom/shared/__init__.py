"""One robot for the whole class: a queue says who drives it, and the others watch."""
