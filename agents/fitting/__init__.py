"""How black-box laws are fitted to trials; the laws themselves run without these."""
