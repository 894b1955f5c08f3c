"""Learned residual policies: features, networks, and training by stable-baselines3 (in `training`)."""
