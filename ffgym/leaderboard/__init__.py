"""Where all agents are compared: the same circles and plants for each, statistics, result files, a page."""
