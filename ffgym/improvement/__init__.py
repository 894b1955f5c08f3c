"""What a diagnosis gains in control."""
