"""Learning feed-forward control: the training loop, what it keeps, first weights."""
