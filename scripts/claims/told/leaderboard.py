"""What pages tell of stored results of the leaderboard."""

from collections.abc import Iterator

from ffgym.leaderboard.comparison.samples import WORKCELLS
from scripts.claims.claim import claim
from scripts.tables.leaderboard import held_out, row_of

RESULTS = "ffgym leaderboard --out docs/leaderboard/results"


def left(name: str, group: str = WORKCELLS) -> float:
    """Error that a row leaves [%] on held-out circles of a group of plants."""
    return 100 * row_of(group, name).score.left


@claim(RESULTS)
def what_we_found() -> Iterator[str]:
    """The table of the README."""
    feedback = [line for line in held_out(WORKCELLS).lines if line.row.feedback and line.row.base == "elastic"]
    least, most = (100 * choose(line.score.left for line in feedback) for choose in (min, max))
    lap = row_of(WORKCELLS, "fitted").score.robot_seconds
    yield f"dynamic LuGre feed-forward, nominal numbers | {left('lugre_dynamic'):.0f} % |"
    yield f"elastic feed-forward, nominal numbers | {left('elastic'):.0f} % |"
    yield f"policies of reinforcement learning | {least:.0f} to {most:.0f} % |"
    yield f"fitted to one lap of one circle ({lap:.1f} s) | {left('fitted'):.0f} % |"
    yield f"that a network reads from that lap | {left('amortised'):.0f} % |"
