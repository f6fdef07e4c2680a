"""The paper's experiment: the errors of each method on simulated or recorded drives."""
