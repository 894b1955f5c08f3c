"""A robot on a page: skeleton, looks, tables of the check; predicted torque."""
