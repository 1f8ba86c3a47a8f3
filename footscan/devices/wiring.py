"""Which bits of a digital I/O module mean what: outputs and inputs as numbers, and back."""

from typing import Any

from footscan.config.io_models import InputWiringModel, OutputWiringModel
from footscan.devices.values import ALL_OFF, Inputs, Outputs
from footscan.errors import InterlockError


def bits_from_outputs(outputs: Outputs, wiring: OutputWiringModel) -> int:
    """The module's output word. What is not wired has no bit.

    Raises:
        InterlockError: A speed that the wired bits cannot express.
    """
    if outputs.speed_step >= 1 << len(wiring.speed):
        raise InterlockError(
            f"speed step {outputs.speed_step} was asked for and the {len(wiring.speed)} wired speed outputs can only "
            f"say 0 to {(1 << len(wiring.speed)) - 1}; wire more of them or use fewer speeds."
        )
    return sum(_bit(_wanted(name, outputs) != _inverted(name, wiring), at) for name, at in wiring.channels.items())


def outputs_from_bits(bits: int, wiring: OutputWiringModel) -> Outputs:
    """Inverse of `bits_from_outputs`; what is not wired is off."""
    on = {name: bool(bits >> at & 1) != _inverted(name, wiring) for name, at in wiring.channels.items()}
    speed = sum(_bit(on.pop(f"speed{place}"), place) for place in range(len(wiring.speed)))
    return Outputs(**on, speed_step=speed)


def bits_when_safe(wiring: OutputWiringModel) -> int:
    """The output word with everything off."""
    return bits_from_outputs(ALL_OFF, wiring)


def used_bits(wiring: OutputWiringModel) -> int:
    """Ones where an output is wired."""
    return sum(1 << at for at in wiring.channels.values())


def inputs_from_bits(bits: int, wiring: InputWiringModel, time_s: float, **module: bool) -> Inputs:
    """What the switches say; a button that is not wired is never pressed."""
    closed = {name: bool(bits >> at & 1) != (name in wiring.inverted) for name, at in wiring.channels.items()}
    return Inputs(time_s, **closed, **module)


def bits_from_inputs(inputs: Inputs, wiring: InputWiringModel) -> int:
    """The input word that says this."""
    return sum(_bit(getattr(inputs, name) != (name in wiring.inverted), at) for name, at in wiring.channels.items())


def _wanted(name: str, outputs: Outputs) -> bool:
    if name.startswith("speed"):
        return bool(outputs.speed_step >> int(name.removeprefix("speed")) & 1)
    value: Any = getattr(outputs, name)
    return bool(value)


def _inverted(name: str, wiring: OutputWiringModel) -> bool:
    return name.rstrip("0123456789") in wiring.inverted


def _bit(on: bool, place: int) -> int:
    return int(on) << place
