"""Which effects explain a log, one after the other, and how sure that is."""
