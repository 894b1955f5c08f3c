"""KUKA Robot Sensor Interface: corrections of axes to a program that the controller runs, XML over UDP.

The controller sends <Rob> with measured and planned axes once in 4 ms (IPO_FAST) or 12 ms (IPO), and expects <Sen> with
the same IPOC, its clock in milliseconds, before the next one. AKorr is the whole correction, in degrees (linear axes in
millimetres), for RSI_ON(#ABSOLUTE): increments of #RELATIVE that are lost would stay in the sum for ever. The element
<Run>, which the user's RSI context sets, is 1 from the instant at which the program begins to move.
"""

import xml.etree.ElementTree as ET

import numpy as np

from ffgym.core.errors import FFGymError
from ffgym.core.types import Array
from ffgym.deployment.streams.wire import Feedback, JointAxes, PacketError, StreamCommand

RUN = "Run"
"""Element that says that the program moves."""
_MOST_JOINTS = 6
_LONGEST = 8192
"""Bytes of the longest telegram; a context sends at most 64 signals."""
_UINT32 = 2**32


class RsiWire:
    """Telegrams of RSI."""

    torques = False
    unsolicited = False
    needs_answers = True
    clock_step = 0.001
    number_step = 0.001
    wrap = _UINT32

    def __init__(self, axes: JointAxes, *, cycle: float = 0.004) -> None:
        """Prepare telegrams for a robot with `axes`, six at most; `cycle` [s] is 0.004 or 0.012."""
        if axes.n > _MOST_JOINTS:
            raise FFGymError(f"RSI sends {_MOST_JOINTS} axes of a robot in AIPos, this one has {axes.n}.")
        self.axes, self.cycle = axes, cycle
        self._names = [f"A{j + 1}" for j in range(axes.n)]

    def decode_feedback(self, data: bytes) -> Feedback:
        """Read a <Rob> telegram."""
        root = _parse(data, "Rob")
        clock = _read_ipoc(root)
        position = self.axes.from_degrees(self._read_axes(root, "AIPos"))
        run = root.findtext(RUN)
        if run is None or run.strip() not in ("0", "1"):
            raise PacketError("no Run")
        return Feedback(sequence=clock, time=1e-3 * clock, position=position, started=run.strip() == "1", token=clock)

    def encode_command(self, command: StreamCommand) -> bytes:
        """Write a <Sen> telegram with the correction."""
        return (
            f'<Sen Type="ImFree"><AKorr {self._write_axes(command.correction)}/><IPOC>{command.token}</IPOC></Sen>'
        ).encode()

    def encode_feedback(self, feedback: Feedback, planned: Array) -> bytes:
        """Write a <Rob> telegram."""
        ipoc = round(1e3 * feedback.time) % _UINT32
        return (
            f'<Rob Type="KUKA"><AIPos {self._write_axes(feedback.position)}/><ASPos {self._write_axes(planned)}/>'
            f'<Delay D="0"/><{RUN}>{int(feedback.started)}</{RUN}><IPOC>{ipoc}</IPOC></Rob>'
        ).encode()

    def decode_command(self, data: bytes) -> StreamCommand:
        """Read a <Sen> telegram; what it holds is a correction."""
        root = _parse(data, "Sen")
        clock = _read_ipoc(root)
        numbers = np.array(self._read_axes(root, "AKorr"))
        if len(numbers) != self.axes.n or not np.isfinite(numbers).all():
            raise PacketError("not finite")
        correction, none = numbers / self.axes.scale, np.zeros(self.axes.n)
        return StreamCommand(
            sequence=clock,
            time=1e-3 * clock,
            position=correction,
            correction=correction,
            velocity=none,
            effort=none,
            token=clock,
        )

    def _write_axes(self, values: Array) -> str:
        numbers = (values * self.axes.scale).tolist()
        return " ".join(f'{name}="{number:.9f}"' for name, number in zip(self._names, numbers, strict=True))

    def _read_axes(self, root: ET.Element, tag: str) -> list[float]:
        element = root.find(tag)
        if element is None:
            raise PacketError(f"no {tag}")
        try:
            return [float(element.attrib[name]) for name in self._names]
        except KeyError:
            raise PacketError("number of joints") from None
        except ValueError:
            raise PacketError("not a number") from None


def _parse(data: bytes, tag: str) -> ET.Element:
    """Parse a telegram in UTF-8; declarations, which could define entities without end, are none in any encoding."""
    if len(data) > _LONGEST or b"<!" in data or b"\0" in data:  # UTF-16 has zeros
        raise PacketError("not a message")
    try:
        root = ET.fromstring(data, ET.XMLParser(encoding="utf-8"))
    except (ET.ParseError, ValueError):
        raise PacketError("not a message") from None
    if root.tag != tag:
        raise PacketError("kind of message")
    return root


def _read_ipoc(root: ET.Element) -> int:
    text = (root.findtext("IPOC") or "").strip()
    if not (text.isascii() and text.isdigit() and len(text) <= 10):
        raise PacketError("no sequence number or time")
    return int(text)
