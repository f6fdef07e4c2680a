"""The paper's experiment: simulated or recorded drives, and how far each method is off."""
