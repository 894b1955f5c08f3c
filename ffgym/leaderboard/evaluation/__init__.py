"""What agents did: they run on plants, in jobs that any process can do, and are scored."""
