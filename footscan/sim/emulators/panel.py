"""What is wired to an emulated module: a plain panel for people and tests, and the terminals of a simulated world."""

import threading
from dataclasses import dataclass
from typing import Protocol

from footscan.config.io_models import AdamModel
from footscan.devices.values import Inputs, Outputs
from footscan.devices.wiring import bits_from_inputs, outputs_from_bits


@dataclass(frozen=True)
class Switching:
    """From this moment the outputs were these."""

    time_s: float
    outputs: Outputs


class WiredPanel:
    """Remembers every change of the outputs; its inputs are what somebody last set."""

    def __init__(self, model: AdamModel, inputs: Inputs) -> None:
        self.inputs = inputs
        self._model, self._lock = model, threading.Lock()
        self._history: list[Switching] = []

    def switch(self, bits: int, time_s: float) -> None:
        """The outputs have become this word."""
        with self._lock:
            self._history.append(Switching(time_s, outputs_from_bits(bits, self._model.outputs)))

    def input_bits(self, time_s: float) -> int:
        """The input word."""
        return bits_from_inputs(self.inputs, self._model.inputs)

    @property
    def history(self) -> list[Switching]:
        """Every change so far."""
        with self._lock:
            return list(self._history)

    @property
    def outputs(self) -> Outputs:
        """What is on now."""
        history = self.history
        return history[-1].outputs if history else outputs_from_bits(0, self._model.outputs)


class WiredWorld(Protocol):
    """The part of a simulated world that hangs on a module's terminals."""

    def set_outputs(self, outputs: Outputs) -> None:
        """Lasers, motor, lamp and buzzer get this."""
        ...

    def inputs(self) -> Inputs:
        """The switches."""
        ...


class WorldPanel:
    """A simulated world behind the terminals of an emulated module."""

    def __init__(self, world: WiredWorld, model: AdamModel) -> None:
        self._world, self._model = world, model

    def switch(self, bits: int, time_s: float) -> None:
        """The outputs have become this word."""
        self._world.set_outputs(outputs_from_bits(bits, self._model.outputs))

    def input_bits(self, time_s: float) -> int:
        """The input word."""
        return bits_from_inputs(self._world.inputs(), self._model.inputs)
