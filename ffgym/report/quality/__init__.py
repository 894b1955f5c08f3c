"""What the quality gate found, as text and as a page."""
