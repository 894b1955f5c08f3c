"""A table to fill in for a new robot: what is asked, where answers are found, and what can be proposed."""
