"""What all families share: laws as agents, laws as files, trials, networks, standard motions."""
