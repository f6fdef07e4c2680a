"""The report on integrity: a page with Stanford diagrams."""
