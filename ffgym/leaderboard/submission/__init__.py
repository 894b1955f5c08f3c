"""Agents of others as files: packed with their claims, checked, and run again on observations alone."""
