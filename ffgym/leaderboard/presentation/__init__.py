"""Presentation of the standings: on the terminal, and as one page with table, pictures and cards."""
