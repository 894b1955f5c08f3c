"""What the simulation gets wrong, why, and how sure that is."""
