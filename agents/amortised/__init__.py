"""Amortised estimation: a network that maps a short recording of a machine to numbers of a model of it."""
