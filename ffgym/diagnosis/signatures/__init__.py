"""Effects along a replay, as columns of a regression."""
