"""The report of the experiment: an HTML page with figures."""
