"""From a description to a MuJoCo model: motors, springs, looks, exact MJCF, fingerprint."""
