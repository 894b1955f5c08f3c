"""Diagnosis from a table of path errors: structures of the model that are fitted to some rows and judged on others."""
