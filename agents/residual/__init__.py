"""Learned residual policies: what they see, their networks, and how stable-baselines3 trains them (in `learning`)."""
