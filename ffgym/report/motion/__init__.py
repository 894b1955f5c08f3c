"""Any motion on a page: path of the tool, errors, torques."""
