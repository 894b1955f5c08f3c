"""B-spline bases, and how the catalogue trains networks on them."""
