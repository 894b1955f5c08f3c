"""Report on a robot: skeleton, looks, tables of the check."""
