"""Parts of `scripts.calibrate_workcell`."""
