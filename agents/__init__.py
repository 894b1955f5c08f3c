"""Feed-forward methods: one file per family; `LawAgent` runs any of them with stable-baselines3's `predict`."""

from agents.common.law_agent import LawAgent as LawAgent
from agents.lugre import dynamic_lugre as dynamic_lugre
from agents.lugre import static_lugre as static_lugre
