"""What docs/reproduction.md tells of the record of `python -m scripts.thesis`."""

from collections.abc import Iterator

import numpy as np

from scripts.claims.claim import claim
from scripts.claims.told.constants import CODE
from scripts.tables.thesis import claim_of, count_verdicts, hold, items
from scripts.thesis.claims import CLEAR, GOOD_FIT, MOST, ROUGH, SIMILAR, ZERO
from scripts.thesis.measured_friction import LADDERS

AGAIN = "python -m scripts.claims --record thesis"


def shares(name: str, key: str = "value") -> list[float]:
    """Values or limits of the comparisons of a claim [%]."""
    return [100 * check[key] for check in claim_of(name)["checks"]]


@claim(CODE)
def constants_of_verdicts() -> Iterator[str]:
    """Numbers that words of the thesis become."""
    yield f'{100 * MOST:g} % where the thesis says "in general"'
    yield f'"significant" is {100 * CLEAR:g} % of an error gone, "zero" or "the same curve" {100 * ZERO:g} % left,'
    yield (
        f'"similar" {SIMILAR:.2f} between two reductions, a "reasonable approximation" an RMS difference of '
        f"{100 * ROUGH:g} % of the RMS friction"
    )


@claim(CODE)
def speeds_of_ladders() -> Iterator[str]:
    """Speeds of a joint that is identified."""
    speeds = [speed for ladder in LADDERS for speed in ladder]
    yield f"at motor speeds from {min(speeds):g} to {max(speeds):g} rad/s"


@claim(AGAIN)
def where_verdicts_hang_on_words() -> Iterator[str]:
    """Verdicts that another constant would turn."""
    half = [share < 50 for share in shares("5.11-static")]
    assert max(*shares("5.11-extended"), *shares("5.19-near")) < 50
    yield (
        f"At 50 % instead of {100 * ROUGH:g} %, 5.11 would hold partly for the static network ({sum(half)} of "
        f"{len(half)} joints) and hold for the extended one, and 5.19 would hold."
    )
    alike = [check["value"] < 0.10 for check in claim_of("4.7-alike")["checks"]]
    assert 0.5 <= np.mean(alike) < 1
    yield f'At 0.10 instead of {SIMILAR:.2f}, "as much at p3 as at p1" (4.7) would hold partly.'
    fits = [check["value"] > 70 for check in claim_of("6.11-hysteresis")["checks"]]
    yield (
        f"call a fit good from {GOOD_FIT:g} %, on data without noise. At 70 %, the {100 * ROUGH:g} % of measured "
        "friction,"
    )
    yield f"would count as that of LuGre on {sum(fits)} of {len(fits)} starts"
    less = {
        name: [check["value"] < check["limit"] / 0.75 for check in claim_of(name)["checks"]]
        for name in ("T6.1-better", "6.6-original")
    }
    records, others = less.values()
    yield (
        f"ask for 25 % less error than the original parameters leave. If any less counted, both would hold "
        f"({sum(records)} of {len(records)} records, {sum(others)} of {len(others)})"
    )
    quickly, feedback = shares("5.6-quickly"), shares("5.8-feedback")
    zero = 5 * feedback[1] / shares("5.8-feedback", "limit")[1]
    yield f"miss by little with the extended network: {quickly[2]:.1f} % against 10 %, {zero:.1f} % against 5 %."
    lower = hold(claim_of("T5.2-extended")["published"]).replace(" of ", " circles of ")
    yield f"a lower RMS error of the extended network on {lower}"


@claim(AGAIN)
def what_does_not_hold() -> Iterator[str]:
    """Sizes behind the claims of chapters 4 and 5 that do not hold."""
    rows = items()["table-4.1"]["tables"][0]["rows"]
    left, published = (
        np.mean([row["entries"]["lugre_dynamic"][key] for row in rows]) for key in ("rms", "published_rms")
    )
    entries = [row["entries"]["lugre_dynamic"] for row in rows]
    assert not any(2 / 3 <= entry["rms"] / entry["published_rms"] <= 1.5 for entry in entries)
    yield (
        f"leaves a mean of {left:.3f} mm at 10 mm/s, where the real robot kept {published:.3f} mm (Table 4.1: none of "
        f"{len(entries)} numbers is within a factor of 1.5)"
    )
    better, dynamic = claim_of("T4.2-better"), claim_of("T4.2-dynamic")
    yield f"on {hold(better['checks'])} circles, and {hold(dynamic['checks'])}."
    yield f"Of the published numbers {hold(better['published'])} and {hold(dynamic['published'])} bear it."
    static, fast = shares("5.11-static"), shares("5.19-near")
    extended = [*shares("5.11-extended"), *shares("5.11-wrist", "limit")]
    yield f"further from dynamic LuGre than {100 * ROUGH:g} %**"
    yield f"(5.11: static {min(static):.0f} to {max(static):.0f} %,"
    yield f"extended {min(extended):.0f} to {max(extended):.0f} %"
    yield f"(5.19: {min(fast):.0f} to {max(fast):.0f} %)"
    slow, quick = (sum(not check["true"] for check in claim_of(f"T5.{k}-extended")["checks"]) for k in (1, 2))
    yield f"on {slow} of 12 circles at 10 mm/s not the lower path error (Table 5.1), and on {quick} of 12 at 40 mm/s"
    stays = [
        5 * share / limit for share, limit in zip(shares("5.8-feedback"), shares("5.8-feedback", "limit"), strict=True)
    ]
    yield f"{stays[1]:.0f} % (extended) to {stays[0]:.0f} % (static) of the feedback stays"


@claim(AGAIN)
def chapter_6() -> Iterator[str]:
    """Verdicts and parameters of chapter 6."""
    counts = count_verdicts()["chapter-6"]
    yield (
        f"of {counts.total()} claims {counts['holds']} hold, {counts['partly']} hold partly, "
        f"{counts['does not hold']} does not hold."
    )
    thesis, ours, between = zip(*(row[1:4] for row in items()["figure-6.1"]["numbers"][0]["rows"]), strict=True)
    yield f"({', '.join(ours[:3])}; thesis {', '.join(thesis[:3])})"
    yield f"sigma_0 = {ours[4]}, sigma_1 = {ours[5]}, within whose intervals ({between[4]}, {between[5]})"
    yield f"the thesis' {float(thesis[4]):.0f} and {float(thesis[5]):.2f} lie"


@claim(AGAIN)
def identified_beside_original() -> Iterator[str]:
    """What the identified model leaves of the records of Table 6.1."""
    off = [check["where"].split(",")[0] for check in claim_of("6.5-fit")["checks"] if not check["true"]]
    assert off == ["record 5", "record 8", "record 13"]
    yield f"off by more than {100 * ROUGH:g} %** of the RMS friction"
    rows = {
        int(row[0]): [float(cell) for cell in (*row[1:3], *row[4:])]
        for row in items()["table-6.1"]["numbers"][0]["rows"]
    }
    left = {record: found / old for record, (*_, old, found) in rows.items()}
    fast = [1 - left[record] for record in (10, 15)]
    yield f"on the two fastest records {100 * min(fast):.0f} to {100 * max(fast):.0f} % better"
    slow = [left[record] for record, (_, frequency, *_) in rows.items() if frequency <= 0.5]
    frequencies = sorted({frequency for _, frequency, *_ in rows.values() if frequency <= 0.5})
    assert len(frequencies) == 2
    yield (
        f"At {frequencies[0]:g} and {frequencies[1]:g} Hz new parameters leave {100 * min(slow):.0f} to "
        f"{100 * max(slow):.0f} % of what the old ones leave"
    )


@claim(AGAIN)
def beyond_the_thesis() -> Iterator[str]:
    """What elastic feed-forward removes, and networks at speeds that they were not trained at."""
    gone = [100 - share for share in shares("agents-elastic")]
    yield f"elastic feed-forward removes {gone[0]:.1f} % and {gone[1]:.0f} % of what dynamic LuGre leaves there"
    rows = {row[0]: row[1:] for row in items()["other-speeds"]["numbers"][0]["rows"]}

    def told(network: str, trained: int, used: int) -> tuple[float, int]:
        error, change = rows[f"{network} B-spline network, trained at {trained} mm/s"][used].split(" (")
        return float(error), int(change.split("%")[0])

    slow, fast = ([told(network, speed, 1)[1] for network in ("static", "extended")] for speed in (10, 40))
    yield (
        f"At 40 mm/s networks of 10 mm/s remove {slow[0]} and {slow[1]} % of the motor error, those of 40 mm/s "
        f"{fast[0]} and {fast[1]} %."
    )
    slow, fast = ([told(network, speed, 0)[1] for network in ("static", "extended")] for speed in (10, 40))
    yield (
        f"Networks of 40 mm/s remove {fast[0]} and {fast[1]} % of the motor error at 10 mm/s, where {slow[0]} and "
        f"{slow[1]} % can be had."
    )
    yield f"as if it had been trained there, {told('static', 40, 0)[0]:.4f} mm"
    yield f"{told('extended', 40, 0)[0]:.3f} against {told('extended', 10, 0)[0]:.3f} mm"
