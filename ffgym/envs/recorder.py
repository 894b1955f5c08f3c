"""Episodes as recordings: the same columns as `ffgym.simulation` writes, and as a measured log has."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ffgym.core.errors import FFGymError, check_number, check_whole
from ffgym.core.types import Array, IntArray
from ffgym.recordings import Recording
from ffgym.simulation import RECORD_DT, Sensor
from ffgym.simulation.run import record_stride
from ffgym.simulation.sensors import check_sensors, measure
from ffgym.simulation.trace import Added, ReferenceRows, Trace, to_recording

if TYPE_CHECKING:
    from ffgym.envs.core import TrackingCore


class EpisodeRecorder:
    """Collects finished episodes of an environment as recordings; give it as `recorder=` to one environment.

    Args:
        record_dt: sample time [s]; a multiple of the physics step that divides the control step.
        sensors: models of the sensors; none gives the exact state.
        seed: seed of the sensors' noise.
        keep: number of the last episodes to keep; None keeps all (10 MB for the longest circle test).
        on_episode: function that is called with each recording when its episode ends, e.g. to write it to a file.
    """

    def __init__(
        self,
        *,
        record_dt: float = RECORD_DT,
        sensors: Sequence[Sensor] = (),
        seed: int = 0,
        keep: int | None = None,
        on_episode: Callable[[Recording], None] | None = None,
    ) -> None:
        self._keep = None if keep is None else check_whole("keep", keep, low=0)
        self._record_dt = check_number("record_dt", record_dt, unit="s", low=0.0, open_low=True)
        check_sensors(sensors)
        if on_episode is not None and not callable(on_episode):
            raise FFGymError(f"on_episode = {on_episode!r} must be a function of a recording.")
        self._sensors, self._on_episode = tuple(sensors), on_episode
        self._rng = np.random.default_rng(check_whole("seed", seed, low=0))
        self._owner: TrackingCore | None = None
        self._parts: dict[int, list[tuple[Array | None, ...]]] = {}
        self._actions: dict[int, list[Array]] = {}
        self.recordings: list[Recording] = []
        """Finished episodes, oldest first."""

    def claim(self, core: "TrackingCore") -> None:
        """Serve this environment from now on, and no other.

        Raises:
            FFGymError: if it serves another one already, or if its sample time does not fit.
        """
        if self._owner is not None and self._owner is not core:
            raise FFGymError("An EpisodeRecorder serves one environment; make one for each.")
        self._stride = record_stride(core.plant, self._record_dt)
        self._owner = core

    def begin(self, core: "TrackingCore", ids: IntArray) -> None:
        """Begin the episodes of sub-environments `ids`; unfinished ones of theirs are dropped."""
        engine = core.plant.batch
        state = (engine.qpos, engine.qvel, engine.act, core.plant.reading())
        for i in ids.tolist():
            self._parts[i] = [tuple(None if part is None else part[i : i + 1].copy() for part in state)]
            self._actions[i] = [core.rows[i, core.columns.base].copy()]

    def add(self, core: "TrackingCore", ids: IntArray, states: Sequence[Array | None], action: Array) -> None:
        """Keep states of one control step of sub-environments `ids`, and their actions (B', N).

        `states` are qpos, qvel, act (B', S, ...), and what servos read, None if they read nothing.
        """
        rows = slice(self._stride - 1, None, self._stride)
        added = core.compute_added(action, ids)
        for k, i in enumerate(ids.tolist()):
            self._parts[i].append(tuple(None if part is None else part[k, rows].copy() for part in states))
            self._actions[i].append(added[k])

    def end(self, core: "TrackingCore", ids: IntArray) -> None:
        """Turn the episodes of sub-environments `ids` into recordings."""
        for i in ids.tolist():
            recording = self.recording(core, i)
            self.recordings.append(recording)
            if self._keep is not None:
                del self.recordings[: max(0, len(self.recordings) - self._keep)]
            if self._on_episode is not None:
                self._on_episode(recording)

    def recording(self, core: "TrackingCore", i: int) -> Recording:
        """Make the recording of the episode of sub-environment `i` up to now."""
        motion = core.motions[i]
        assert motion is not None  # an episode has begun
        plant = core.plant
        qpos, qvel, act = (
            np.concatenate([parts[k] for parts in self._parts[i] if parts[k] is not None]) for k in range(3)
        )
        readings = [part for *_, part in self._parts[i] if part is not None]
        reading = np.concatenate(readings) if len(readings) == len(self._parts[i]) else None
        trace = Trace(dt=self._stride * plant.physics_dt, qpos=qpos, qvel=qvel, act=act, reading=reading)
        rows = ReferenceRows.of(motion.arm, motion.reference, plant.n_substeps // self._stride)
        added = np.stack(self._actions[i])
        exact = to_recording(
            trace,
            rows.first(len(qpos)),
            law="agent",
            added=Added(torque=added)
            if core.corrections is None
            else Added(torque=np.zeros_like(added), correction=added),
            arm=motion.arm,
            plant=plant,
            index=i,
            meta={"task": motion.task, "plant": plant.robots[i].name},
        )
        return measure(plant.machines[i].seen(exact), self._sensors, self._rng)
