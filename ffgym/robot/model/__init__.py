"""MuJoCo models of descriptions: motors, springs, looks, exact MJCF, fingerprint."""
