"""Effects of machines as machine code, made from their formulas in NumPy."""
