"""FMUs compared with the simulation: FMPy validates them, and runs them along the motion that they were written for."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.temporaries import scratch_folder
from ffgym.core.types import Array
from ffgym.deployment.code.model_description import Version
from ffgym.paths import Reference
from ffgym.recordings import Recording

TOLERANCE = 1e-9
"""Largest difference from the simulation in SI units, as of motions that plain MuJoCo plays."""
_SETPOINTS = ("position", "velocity", "torque")


@dataclass(frozen=True, kw_only=True)
class FmuCheck:
    """Comparison of FMUs with the simulation, along the motion of the program."""

    version: str
    """Version of FMI."""
    steps: int
    differences: dict[str, float]
    """Largest difference of each quantity, SI units."""

    @property
    def largest_difference(self) -> float:
        """Largest difference of all, SI units; NaN if one is."""
        return float(np.max(list(self.differences.values())))


def validate(path: Path) -> None:
    """Let FMPy validate an FMU.

    Raises:
        FFGymError: if it finds a problem.
    """
    from fmpy.validation import validate_fmu

    if problems := validate_fmu(str(path)):
        raise FFGymError(f"{path.name}: FMPy finds {'; '.join(problems)}. Please report it, with robot and motion.")


class Slave:
    """An FMU that runs, in either version, with names of variables; the first part of a name is its quantity."""

    def __init__(self, path: str | Path) -> None:
        """Unpack and initialise an FMU."""
        import fmpy
        from fmpy.simulation import instantiate_fmu

        self._files = ExitStack()
        self._folder = str(self._files.enter_context(scratch_folder()))
        fmpy.extract(str(path), self._folder)
        self._description = fmpy.read_model_description(self._folder)
        self._fmu: Any = instantiate_fmu(self._folder, self._description, "CoSimulation")
        self._fmi2 = self._description.fmiVersion.startswith("2")
        if self._fmi2:
            self._fmu.setupExperiment(startTime=0.0)
        self._fmu.enterInitializationMode()
        self._fmu.exitInitializationMode()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._fmu.terminate()
        self._fmu.freeInstance()
        self._files.close()

    def _references(self, quantity: str) -> list[int]:
        variables = self._description.modelVariables
        return [variable.valueReference for variable in variables if variable.name.split(".")[0] == quantity]

    @property
    def quantities(self) -> list[str]:
        """Quantities of the variables, but for the time."""
        return list(dict.fromkeys(v.name.split(".")[0] for v in self._description.modelVariables if v.name != "time"))

    def get(self, quantity: str) -> Array:
        """Get a quantity of all joints."""
        references = self._references(quantity)
        return np.array(self._fmu.getReal(references) if self._fmi2 else self._fmu.getFloat64(references))

    def set(self, quantity: str, values: Array) -> None:
        """Set a quantity of all joints."""
        write = self._fmu.setReal if self._fmi2 else self._fmu.setFloat64
        write(self._references(quantity), values.tolist())

    def step(self, time: float, step: float) -> None:
        """Take a step."""
        self._fmu.doStep(currentCommunicationPoint=time, communicationStepSize=step)


def compare_with_simulation(
    paths: Sequence[Path], version: Version, recording: Recording, reference: Reference
) -> FmuCheck:
    """Run a plant, and its program if there is one, along the motion, and compare every control step.

    Args:
        paths: plant, then program; without one the plant gets set-points of the simulation.
        version: version of FMI, for the result.
        recording: what the simulation recorded every control step.
        reference: the motion.

    Raises:
        FFGymError: if a number differs by more than the tolerance.
    """
    u_ff, u_lff = (recording.joint_array(f"{name}.effort") for name in ("feedforward", "compensation"))
    wanted = {"position": reference.motor_q, "velocity": reference.motor_dq, "torque": u_ff + u_lff}
    with ExitStack() as running:
        found = _run([running.enter_context(Slave(path)) for path in paths], wanted, reference)
    wanted |= {"added_torque": u_lff}
    wanted |= {
        name: recording.joint_array(name.replace("_", ".", 1))
        for name in ("motor_position", "motor_velocity", "link_position", "link_velocity")
    }
    if "tcp" in found:
        wanted["tcp"] = np.stack([recording[f"tcp.position.{axis}"] for axis in "xyz"], axis=1)
    differences = {name: float(np.abs(rows - wanted[name][-len(rows) :]).max()) for name, rows in found.items()}
    check = FmuCheck(version=version, steps=len(reference.t) - 1, differences=differences)
    if not check.largest_difference <= TOLERANCE:
        name = next(key for key, value in differences.items() if not value <= TOLERANCE)
        raise FFGymError(
            f"{name} of the FMU (FMI {version}) differs from the simulation by {differences[name]:.3g} along "
            f"{reference.name}, may by {TOLERANCE:g} in SI units; nothing is written. Please report it."
        )
    return check


def _run(slaves: Sequence[Slave], wanted: dict[str, Array], reference: Reference) -> dict[str, Array]:
    """Run a plant and a program; returns rows of the plant at all samples, of the program from the second one on."""
    plant, program = slaves[0], slaves[1] if len(slaves) > 1 else None
    dt, outputs = reference.robot.servo.control_dt, [name for name in plant.quantities if name not in _SETPOINTS]
    rows: dict[str, list[Array]] = {name: [plant.get(name)] for name in outputs}
    if program is not None:
        rows |= {name: [] for name in program.quantities}
    for k in range(len(reference.t) - 1):
        for name in _SETPOINTS:
            plant.set(name, wanted[name][k + 1] if program is None else program.get(name))
        if program is not None:
            for name in program.quantities:
                rows[name].append(program.get(name))
            program.step(k * dt, dt)
        plant.step(k * dt, dt)
        for name in outputs:
            rows[name].append(plant.get(name))
    return {name: np.stack(values) for name, values in rows.items()}
