"""Why a submission is not accepted."""

from ffgym.core.errors import FFGymError

LONGEST = 500
"""Letters of a reason."""


class Refused(FFGymError):
    """A submission that is not accepted; the message is the reason.

    Args:
        check: name of the check that it did not pass, in `ffgym.leaderboard.submission.verify.CHECKS`.
        reason: what is wrong, and what would be right.
    """

    def __init__(self, check: str, reason: str) -> None:
        plain = "".join(letter if letter.isprintable() else "?" for letter in reason)  # it may be an agent's own words
        if len(plain) > LONGEST:
            plain = plain[: LONGEST - 3] + "..."
        super().__init__(f"refused, {check}: {plain}")
        self.check = check
        self.reason = plain
