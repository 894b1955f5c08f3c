"""What the machine's controller does otherwise than documented."""
