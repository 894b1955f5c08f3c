"""Report on any motion: path of the tool, errors, torques."""
