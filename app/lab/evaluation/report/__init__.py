"""The report of the experiment: a page with figures."""
