"""The standings for people: on the terminal, and as one page with table, pictures and cards."""
