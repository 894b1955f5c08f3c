"""Search for the effects that explain a log, one after the other, and comparison with their rivals."""
