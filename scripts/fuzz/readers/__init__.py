"""Readers of the project, in groups that share a process: each module has READERS."""
