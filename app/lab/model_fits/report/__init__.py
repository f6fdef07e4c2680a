"""The report of the models' statistics: an HTML page with figures."""
