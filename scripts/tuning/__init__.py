"""Parts of `scripts.tune`."""
