"""Compiled physics steps within MuJoCo's own: its control callback, and the addresses of its data."""

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

import mujoco
import numpy as np
from mujoco import batch

from ffgym.core.types import Array, IntArray
from ffgym.simulation.plant.compiled.code import compile_code

FIELDS = ("qpos", "qvel", "act", "ctrl", "qfrc_applied", "qfrc_actuator", "qacc", "xfrc_applied")
"""Fields of MuJoCo's data that a physics step of effects reads or writes."""

_MARK = 4.8271e-301
"""Number by which a simulation of ours is known; chosen: no force that anybody applies."""

_PROBE = """
<mujoco>
  <worldbody><body><joint name="j"/><geom size="1"/></body></worldbody>
  <actuator><general joint="j" dyntype="integrator"/></actuator>
</mujoco>
"""


@cache
def data_offsets() -> dict[str, int]:
    """Offsets [B] of `FIELDS` and of the time in MuJoCo's structure of data, found in a simulation that is made here.

    Pointers are looked for by the addresses that MuJoCo's own Python package gives for their arrays.
    """
    data = mujoco.MjData(mujoco.MjModel.from_xml_string(_PROBE))
    data.time = 1.2345678901e89
    wanted = {getattr(data, name).ctypes.data: name for name in FIELDS}
    wanted[int(np.float64(data.time).view(np.int64))] = "time"
    # fields without elements share the address of the next one, so that the last place is the right one
    found: dict[str, int] = {}
    words = ctypes.cast(data._address, ctypes.POINTER(ctypes.c_int64))
    place = 0
    while len(found) < len(wanted) or words[place] in wanted:
        if (name := wanted.get(words[place])) is not None:
            found[name] = 8 * place
        place += 1
    return found


@cache
def _callback() -> tuple[object, object]:
    """MuJoCo's callback: calls the compiled step of a simulation that bears our mark; kept with its module."""
    text = f"""
define void @callback(ptr %model, ptr %data) {{
entry:
  %slot = getelementptr i8, ptr %data, i64 {data_offsets()["xfrc_applied"]}
  %force = load ptr, ptr %slot
  %mark = load double, ptr %force
  %ours = fcmp oeq double %mark, 0x{np.float64(_MARK).view(np.uint64):016X}
  br i1 %ours, label %step, label %done
step:
  %context.p = getelementptr double, ptr %force, i64 1
  %context.d = load double, ptr %context.p
  %context.i = fptoui double %context.d to i64
  %context = inttoptr i64 %context.i to ptr
  %row.p = getelementptr double, ptr %force, i64 2
  %row.d = load double, ptr %row.p
  %row = fptosi double %row.d to i64
  %function = load ptr, ptr %context
  call void %function(ptr %context, i64 %row, ptr %data)
  br label %done
done:
  ret void
}}
"""
    module = compile_code(text)
    kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)
    return module, kind(module.get_function_address("callback"))


_lock = threading.Lock()
_users = 0


def is_free() -> bool:
    """Tell if no control callback of someone else is set, which ours would replace."""
    return _users > 0 or mujoco.get_mjcb_control() is None


class Marks:
    """Marks of simulations of ours: forces on the world's body, which MuJoCo does not read.

    Args:
        engine: simulations.
        context: table of the compiled step; its first entry is the address of the function.
    """

    def __init__(self, engine: batch.Batch, context: IntArray) -> None:
        self._place = engine.bind("xfrc_applied")[:, 0, :3]
        self._own = np.empty((engine.nsim, 3))
        self._own[:, 0], self._own[:, 1] = _MARK, context.ctypes.data
        self._own[:, 2] = np.arange(engine.nsim)

    @contextmanager
    def set(self, rows: IntArray | slice) -> Iterator[None]:
        """Let physics steps of simulations `rows` begin with the compiled step, for as long as this lasts.

        The callback is one for the whole process, and leaves all simulations alone that do not bear a mark.
        """
        global _users
        with _lock:
            _users += 1
            if _users == 1:
                mujoco.set_mjcb_control(_callback()[1])
        self._place[rows] = self._own[rows]
        try:
            yield
        finally:
            self._place[rows] = 0.0
            with _lock:
                _users -= 1
                if _users == 0 and mujoco.get_mjcb_control() is _callback()[1]:
                    mujoco.set_mjcb_control(None)


def address(array: Array | IntArray) -> int:
    """Address of an array's first number."""
    assert array.flags.c_contiguous
    return array.ctypes.data
