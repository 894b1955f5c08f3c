"""Evaluation of agents: runs on plants, in jobs that any process can do, scored by circles."""
