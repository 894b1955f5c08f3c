"""What a diagnosis gains in control: record, diagnose, extend the model, compensate with it, again."""

from ffgym.improvement.gain import Gain as Gain
from ffgym.improvement.gain import Score as Score
from ffgym.improvement.improve import Improvement as Improvement
from ffgym.improvement.improve import improve as improve
from ffgym.improvement.page import improvement_figures as improvement_figures
from ffgym.improvement.page import render_improvement as render_improvement
from ffgym.improvement.rounds import Plan as Plan
from ffgym.improvement.rounds import Round as Round
from ffgym.improvement.text import format_improvement as format_improvement
