"""Mutation of every file that the project reads: whatever it gets, a reader gives a result or one clear error."""
