"""Agents with stable-baselines3's `predict`: one file per family."""

from agents.lugre import LuGreAgent as LuGreAgent
