"""How fast a network may learn: a model of the loop, the map of an iteration, and the check in simulation."""
