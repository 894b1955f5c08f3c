"""Training of residual policies with stable-baselines3; the only part of `ffgym.agents.residual` that needs torch."""
