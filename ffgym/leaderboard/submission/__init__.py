"""Agents of others as files: packed with what they claim, checked, and run again where they see observations only."""
