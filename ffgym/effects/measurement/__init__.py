"""What is between the truth and its measurement."""
