"""The report on integrity: an HTML page with Stanford diagrams."""
