"""A plant that shares no equation of motion, integrator, friction law or servo with the simulation, and an exam on it."""
