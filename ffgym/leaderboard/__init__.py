"""Comparison of all agents: splits, plants, evaluation, statistics, result files, the page, submissions.

Agents are in `ffgym.agents`, numbers of the thesis in `ffgym.published`, tables and figures in `ffgym.report`.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
