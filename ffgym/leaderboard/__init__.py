"""Comparison of all agents: splits, plants, evaluation, statistics, result files, the page, submissions.

Agents stand in `ffgym.agents`, numbers of the thesis in `ffgym.published`, tables and figures in `ffgym.report`.
"""
