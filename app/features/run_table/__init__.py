"""Numbers of runs: how right the estimate was, with which parameters, and what differs."""
