"""What docs/deployment/setpoints.md, streams.md and trial.md tell of constants of the code."""

from collections.abc import Iterator

import numpy as np

from ffgym.deployment.streams import envelope, session, urscript, validity
from ffgym.deployment.streams.protocols import PROTOCOLS, axes_of
from ffgym.deployment.trial import gains, power, rehearsal
from ffgym.paths import RADII
from ffgym.robot import load_robot
from scripts.claims.claim import claim

CODE = "the code itself"


def cycle(protocol: str) -> float:
    """Time between packets of a protocol [s]."""
    return PROTOCOLS[protocol].make_wire(axes_of(load_robot("irb4600_60_205"))).cycle


@claim(CODE)
def circles_of_channels() -> Iterator[str]:
    """Radii of the circles that channels are compared on."""
    small, middle, large = (f"{1e3 * radius:g}" for radius in RADII)
    yield f"of circles of {small}, {middle} and {large} mm at all positions"


@claim(CODE)
def cycles_of_streams() -> Iterator[str]:
    """Cycles of protocols."""
    ms = {name: f"{1e3 * cycle(name):g} ms" for name in PROTOCOLS}
    yield f"joint positions, protobuf over UDP | {ms['egm']} |"
    yield f"XML over UDP | {ms['rsi']}, {ms['rsi_12ms']} |"
    yield f"positions for `servoj`, RTDE over TCP | {ms['rtde']} |"
    yield f"positions and torques for `direct_torque` | {ms['rtde_torque']} |"
    yield f"`JointTrajectory` over DDS | {ms['ros2']} |"
    yield f"positions, speeds, effort | {ms['ros2_effort']} |"


@claim(CODE)
def envelope_of_streams() -> Iterator[str]:
    """Times of the envelope."""
    patience, ramp, longest = (
        1e3 * each for each in (envelope.Envelope.patience, envelope.Envelope.ramp, envelope.LONGEST_SILENCE)
    )
    yield f"the correction leaves within {longest:g} ms of the last valid packet"
    yield f"older than {1e3 * validity._OLDEST:g} ms, or more than {1e3 * validity._AHEAD:g} ms ahead of its time"
    yield (
        f"no valid packet for `patience` ({patience:g} ms) | the correction leaves within `ramp` ({ramp:g} ms): it is "
        f"out {longest:g} ms after the last valid packet"
    )
    yield f"silence of {session._GIVE_UP:g} s, or"
    yield f"within `fade` ({1e3 * envelope.Envelope.fade:g} ms)"
    slow = cycle("rsi_12ms")
    wait = 1e3 * envelope.usual_silence(slow)
    yield f"In the cycle of {1e3 * slow:g} ms (`rsi_12ms`) patience is {wait:g} ms and ramp {longest - wait:g} ms"


@claim(CODE)
def stop_of_urscript() -> Iterator[str]:
    """Silence after which the program on the robot stops it."""
    yield f"It stops the robot after {1e3 * urscript._MISSED * cycle('rtde'):g} ms without a new set-point"


@claim(CODE)
def plans_of_trials() -> Iterator[str]:
    """Caution about pilots, and fewest pairs."""
    one, two, three = (power.count_least_pairs(places) for places in (1, 2, 3))
    yield f"leave open ({100 * power._CAUTION:g} %). With fewer than {one} pairs of one program,"
    yield f"{two} of each of two, {three} of each of three, nothing can be shown"


@claim("1 - sqrt((e_on^2 + n^2) / (e_off^2 + n^2))")
def noise_of_a_tracker() -> Iterator[str]:
    """Gain that noise would make of another."""
    half, whole, noise = 50.0, 100.0, 10.0
    shown = 1 - np.hypot(half, noise) / np.hypot(whole, noise)
    yield f"errors of {half:g} and {whole:g} um under {noise:g} um of noise would show {100 * shown:.0f} %, not"
    yield f"not {100 * (1 - half / whole):g} %."


@claim(CODE)
def throws_of_coins() -> Iterator[str]:
    """Throws of the randomisation test."""
    most = int(np.log2(gains._RESAMPLES))
    yield f"All throws are counted up to {most} pairs, {gains._RESAMPLES} are drawn beyond"


@claim(CODE)
def level_of_trials() -> Iterator[str]:
    """Level of claims of a trial."""
    yield f"are held to {power.LEVEL:g} together"
    yield f"adjusted p at most {power.LEVEL:g},"


@claim(CODE)
def drift_of_trials() -> Iterator[str]:
    """How much friction differs between runs of a rehearsal."""
    yield f"joint differs from run to run by {100 * rehearsal.VARIATION:g} %,"
