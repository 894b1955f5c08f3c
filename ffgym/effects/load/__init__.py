"""What the arm carries: masses, springs, cables."""
