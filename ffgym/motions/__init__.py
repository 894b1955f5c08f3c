"""Motions from files and names (path descriptions, tables, RAPID programs) as references for a robot."""
