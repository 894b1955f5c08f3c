"""How laws learn: bases, training, trials, stability, forgetting, and comparison of agents."""
