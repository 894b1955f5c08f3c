"""modelDescription.xml of FMUs for co-simulation, FMI 2.0 and 3.0."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal
from xml.etree import ElementTree as Xml

Version = Literal["2.0", "3.0"]


@dataclass(frozen=True)
class FmuVariable:
    """Number that goes in or out."""

    name: str
    unit: str
    meaning: str
    start: float | None = None
    """Value at the start, for inputs; None marks an output."""


@dataclass(frozen=True, kw_only=True)
class ModelDescription:
    """Description of a model for co-simulation."""

    name: str
    """Name of the model and of its binary, letters, digits and _."""
    about: str
    tool: str
    token: str
    """Text by which description and binary know each other."""
    variables: tuple[FmuVariable, ...]
    """Inputs, then outputs; their places are their value references, and the time has the next one."""
    stop: float
    """Time at which the experiment ends [s]."""
    step: float
    """Step of the co-simulation that is suggested [s]."""

    @property
    def n_inputs(self) -> int:
        """Number of inputs."""
        return sum(variable.start is not None for variable in self.variables)


_UNITS = {
    "rad": {"rad": "1"},
    "rad/s": {"rad": "1", "s": "-1"},
    "m": {"m": "1"},
    "m/s": {"m": "1", "s": "-1"},
    "N.m": {"kg": "1", "m": "2", "s": "-2"},
    "s": {"s": "1"},
}
"""Exponents of base units."""


def description_text(model: ModelDescription, version: Version) -> bytes:
    """Write modelDescription.xml for a version of the standard."""
    token = "guid" if version == "2.0" else "instantiationToken"
    root = Xml.Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": model.name,
            token: model.token,
            "description": model.about,
            "generationTool": model.tool,
            "variableNamingConvention": "flat",
        },
    )
    Xml.SubElement(
        root,
        "CoSimulation",
        {"modelIdentifier": model.name, "canHandleVariableCommunicationStepSize": "true"}
        | (
            {"canNotUseMemoryManagementFunctions": "true", "canGetAndSetFMUstate": "true"}
            if version == "2.0"
            else {"canGetAndSetFMUState": "true"}
        ),
    )
    units = Xml.SubElement(root, "UnitDefinitions")
    for unit in sorted({variable.unit for variable in model.variables} | {"s"}):
        Xml.SubElement(Xml.SubElement(units, "Unit", {"name": unit}), "BaseUnit", _UNITS[unit])
    experiment = {"startTime": "0", "stopTime": repr(model.stop), "stepSize": repr(model.step)}
    Xml.SubElement(root, "DefaultExperiment", experiment)
    outputs = range(model.n_inputs, len(model.variables))
    (_write_2 if version == "2.0" else _write_3)(root, model, outputs)
    Xml.indent(root)
    return Xml.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _attributes(variable: FmuVariable, reference: int) -> dict[str, str]:
    return {
        "name": variable.name,
        "valueReference": str(reference),
        "causality": "output" if variable.start is None else "input",
        "variability": "continuous",
        "description": variable.meaning,
    }


def _number(variable: FmuVariable) -> dict[str, str]:
    return {"unit": variable.unit} | ({} if variable.start is None else {"start": repr(variable.start)})


def _write_2(root: Xml.Element, model: ModelDescription, outputs: Sequence[int]) -> None:
    """Write variables and structure as FMI 2.0 has them: indices count from 1."""
    variables = Xml.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(model.variables):
        scalar = Xml.SubElement(variables, "ScalarVariable", _attributes(variable, reference))
        Xml.SubElement(scalar, "Real", _number(variable))
    structure = Xml.SubElement(root, "ModelStructure")
    for part in ("Outputs", "InitialUnknowns"):
        unknowns = Xml.SubElement(structure, part)
        for reference in outputs:
            Xml.SubElement(unknowns, "Unknown", {"index": str(reference + 1), "dependencies": ""})


def _write_3(root: Xml.Element, model: ModelDescription, outputs: Sequence[int]) -> None:
    """Write variables and structure as FMI 3.0 has them; the time is a variable, too."""
    variables = Xml.SubElement(root, "ModelVariables")
    for reference, variable in enumerate(model.variables):
        Xml.SubElement(variables, "Float64", _attributes(variable, reference) | _number(variable))
    time = {
        "name": "time",
        "valueReference": str(len(model.variables)),
        "causality": "independent",
        "variability": "continuous",
        "description": "Time of the simulation.",
        "unit": "s",
    }
    Xml.SubElement(variables, "Float64", time)
    structure = Xml.SubElement(root, "ModelStructure")
    for part in ("Output", "InitialUnknown"):
        for reference in outputs:
            Xml.SubElement(structure, part, {"valueReference": str(reference), "dependencies": ""})
