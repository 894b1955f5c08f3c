"""From what a search found to what a diagnosis says."""
