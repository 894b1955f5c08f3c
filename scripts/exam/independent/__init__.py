"""A plant that shares no equation, integrator or servo with the simulation, and an exam of the diagnosis on it."""
