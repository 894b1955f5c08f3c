"""Elastic feed-forward through set-points: what its gain is worth to users whose controllers take no torques.

Idea: the servo gives the torque of `ffgym.agents.elastic` if its set-points are corrected by the inverse of the servo
(`ffgym.control.SetpointChannel`), at one set-point every 4 ms as ABB's EGM takes them (250 Hz). Law, circles and
machines are those of the row `elastic`, so that two rows tell the channels apart and nothing else.

No channel is a method, so that both rows are shown and never ranked.

Between sender and servo stand delay and filter of a controller. Both are constant. A sender that knows them compensates
them (docs/deployment/setpoints.md), and is the row `elastic_setpoints`. A sender that knows nothing of a delay of 8 ms,
two samples, is the row `elastic_setpoints_late`.

Source: corrections by the exact inverse of a known servo are this project's own; 250 Hz and a delay of some samples are
those of externally guided motion (ABB, Application manual, Externally Guided Motion, 3HAC073318).

Run it:

    ffgym leaderboard --agents elastic elastic_setpoints elastic_setpoints_late
"""

from functools import partial

from ffgym.agents.declaration import AgentEntry, AgentSetting, declare
from ffgym.agents.elastic import ElasticLaw, elastic_law
from ffgym.control import LawStyle, SetpointChannel, SetpointResponse

UNKNOWN_DELAY = 0.008
"""Delay that the late sender does not know of [s]: two samples; chosen, as controllers have 4 to 30 ms."""


def _make(name: str, setting: AgentSetting) -> ElasticLaw:
    return elastic_law(setting.arm, setting.controller, name)


declare(
    AgentEntry(
        name="elastic_setpoints",
        title="elastic through set-points",
        about="Elastic feed-forward as corrections of position set-points, one every 4 ms as EGM at 250 Hz, by the "
        "inverse of the nominal servo: what users without access to torques get; shown, never ranked.",
        track="causal, nominal parameters",
        order=12.1,
        page="elastic.md",
        style=LawStyle(label="elastic through set-points", colour="#CB6D51", marker="p"),
        make=partial(_make, "elastic_setpoints"),
        channel=SetpointChannel(),
        ranked=False,
        on_commands=False,
    ),
    AgentEntry(
        name="elastic_setpoints_late",
        title="elastic through late set-points",
        about="Elastic feed-forward as corrections of position set-points, every 4 ms, behind a delay of 8 ms of the "
        "controller that their sender does not know of: what late set-points cost; shown, never ranked.",
        track="causal, nominal parameters",
        order=12.2,
        page="elastic.md",
        style=LawStyle(label="elastic through late set-points", colour="#D9A08B", marker="p"),
        make=partial(_make, "elastic_setpoints_late"),
        channel=SetpointChannel(response=SetpointResponse(delay=UNKNOWN_DELAY), known=SetpointResponse()),
        ranked=False,
        on_commands=False,
    ),
)
