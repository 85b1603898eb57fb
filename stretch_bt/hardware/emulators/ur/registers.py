"""What clients of a controller write: general purpose registers, and the outputs of its control box."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stretch_bt.hardware.emulators.ur.fields import BITS, REGISTERS

__all__ = ["AnalogOutputs", "Registers"]

_WORDS = {"input_bit_registers0_to_31": 0, "input_bit_registers32_to_63": 32}
#: analog outputs go from 4 to 20 mA or from 0 to 10 V
_LEAST, _SPAN = (0.004, 0.0), (0.016, 10.0)


def _bits() -> dict[str, list[bool]]:
    return {"input": [False] * BITS, "output": [False] * BITS}


@dataclass
class Registers:
    """The general purpose registers, and when each integer one was last written, s of the controller."""

    in_int: list[int] = field(default_factory=lambda: [0] * REGISTERS)
    in_double: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)
    out_int: list[int] = field(default_factory=lambda: [0] * REGISTERS)
    out_double: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)
    written: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)
    #: by direction, "input" or "output"
    bits: dict[str, list[bool]] = field(default_factory=_bits)

    def take(self, name: str, value: Any, now: float) -> None:
        """Take an input of RTDE, by its name, at a time, s; a name that is no register is ignored, as is a NaN."""
        kind, _, number = name.rpartition("_")
        if kind == "input_int_register":
            self.in_int[int(number)] = value
            self.written[int(number)] = now
        elif kind == "input_double_register" and math.isfinite(value):
            self.in_double[int(number)] = value
        elif kind == "input_bit_register":
            self.bits["input"][int(number)] = bool(value)
        elif name in _WORDS:
            first = _WORDS[name]
            self.bits["input"][first : first + 32] = [bool(value >> k & 1) for k in range(32)]


@dataclass
class AnalogOutputs:
    """The two analog outputs: a bit each for voltage in place of current, and A or V."""

    types: int = 0
    outputs: list[float] = field(default_factory=lambda: [_LEAST[0]] * 2)

    def take(self, inputs: Mapping[str, Any]) -> None:
        """Take the inputs of one package of RTDE: each output in the mask is set to a part of its range."""
        mask = inputs.get("standard_analog_output_mask", 0)
        for k in range(2):
            part = inputs.get(f"standard_analog_output_{k}", math.nan)
            if mask >> k & 1 and 0.0 <= part <= 1.0:
                kind = inputs.get("standard_analog_output_type", 0) >> k & 1
                self.types = self.types & ~(1 << k) | kind << k
                self.outputs[k] = _LEAST[kind] + _SPAN[kind] * part
