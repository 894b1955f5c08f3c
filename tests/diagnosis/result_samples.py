"""A diagnosis with something in every field, and a hypothesis without size."""

import numpy as np

from ffgym.diagnosis.fit.hypothesis import Hypothesis
from ffgym.diagnosis.result import (
    Cause,
    Diagnosis,
    Drift,
    FittedNumber,
    Level,
    Miswiring,
    Pattern,
    Rival,
    SeparatingMotion,
    Size,
    UnjudgedEffect,
)
from ffgym.effects import EFFECTS


def neutral_hypothesis(name, joint="j2") -> Hypothesis:
    """An effect at numbers that change nothing, or at its defaults."""
    values = {n: np.array(p.neutral if p.default is None else p.default) for n, p in EFFECTS[name].parameters().items()}
    return Hypothesis(kind=EFFECTS[name], joint=joint, source=None, values=values)


def left(measured, noise_floor, before, after):
    """RMS of a level."""
    return {"measured": measured, "noise_floor": noise_floor, "before": before, "after": after}


def full_diagnosis() -> Diagnosis:
    """Ambiguous between two causes on j2, with everything that a result can have."""
    size = Size(name="share", value=0.021, unit="1", interval=(0.019, 0.024))
    cause = Cause(
        effect="load_friction",
        code="F6",
        title="Friction that grows with load",
        joint="j2",
        parameters=(size,),
        fixed={"width": 0.1},
        held_out_gain=0.94,
    )
    rivals = (
        Rival(
            effect="payload",
            joint="",
            held_out_gain=0.93,
            tied=True,
            against="load_friction",
            reason="these motions never reverse at the same load",
        ),
        Rival(
            effect="torque_constant",
            joint="j2",
            held_out_gain=0.41,
            tied=False,
            against="load_friction",
            reason="explains less on motions that were not used",
        ),
    )
    pattern = Pattern(
        channel="torque",
        component="j2",
        variable="load",
        kind="sign-locked function",
        frequency=None,
        amplitude=0.12,
        share=0.8,
        message="the residual of j2 changes sign with the direction and grows with the load",
    )
    line = Pattern(
        channel="torque",
        component="j3",
        variable="time",
        kind="line",
        frequency=17.0,
        amplitude=0.02,
        share=0.3,
        message="17 Hz on j3",
    )
    drift = Drift(
        effect="viscous_level",
        joint="j1",
        motions=("a", "b", "c", "d"),
        days=(0.0, 10.0, 20.0, 30.0),
        changes=(0.1, 0.07, 0.03, 0.0),
        errors=(0.01, 0.01, 0.01, 0.01),
        per_day=-0.0034,
        per_day_error=0.0005,
    )
    return Diagnosis(
        verdict="ambiguous",
        sentence="Joint 2 loses torque with load, or carries more than the model says.",
        robot="irb4600_60_205",
        motions=("diagnosis.slow_triangle", "diagnosis.sine"),
        causes=(cause,),
        numbers=(FittedNumber(entry="friction.viscous", unit="N m s/rad", before=(0.02, 0.01), after=(0.021, 0.01)),),
        drifts=(drift,),
        rivals=rivals,
        patterns=(pattern, line),
        not_excited=(UnjudgedEffect(effect="temperature_friction", joint="", reason="the log spans 2 K"),),
        not_judgeable=(UnjudgedEffect(effect="tool_frame", joint="", reason="no tracker"),),
        wiring=(Miswiring(kind="sign", families=("motor.effort",), joints=("j2",), message="j2 has the wrong sign"),),
        separating_motion=SeparatingMotion(
            between=("load_friction on j2", "payload"),
            protocol="holds",
            toml='[[steps]]\nprotocol = "holds"\n',
            expected=3.2,
        ),
        levels=(
            Level(channel="torque", component="j1", unit="N m", **left(0.5, 0.01, 0.011, 0.0105)),
            Level(channel="torque", component="j2", unit="N m", **left(0.6, 0.012, 0.09, 0.013)),
            Level(channel="tool", component="x", unit="m", **left(1e-3, 2e-6, 9e-6, 3e-6)),
        ),
        threshold=0.06,
        quality=("diagnosis.sine: j6 hardly moves",),
        provenance={"seed": 0, "versions": {"ffgym": "0.1"}},
    )
