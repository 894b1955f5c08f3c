"""Comparison of rows: samples, intervals by bootstrap, scores, ranks and ties."""
