"""The report of the statistics of the models: a page with figures."""
