"""`[devices.io]` of a rig file: a digital I/O module of the ADAM/DCON family and what is wired to its terminals."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from footscan.config.port_name import PortName
from footscan.config.toml_file import Strict, tuple_from_list

Channel = Annotated[int, Field(ge=0, le=15)]
Dialect = Literal["adam4055", "adam4150", "i7050", "i7060"]


@dataclass(frozen=True)
class Terminals:
    """Digital outputs and inputs of a module, and the name it gives itself."""

    outputs: int
    inputs: int
    name: str


TERMINALS: dict[Dialect, Terminals] = {
    "adam4055": Terminals(8, 8, "4055"),
    "adam4150": Terminals(8, 7, "4150"),
    "i7050": Terminals(8, 7, "7050"),
    "i7060": Terminals(4, 4, "7060"),
}


class OutputWiringModel(Strict):
    """`[devices.io.outputs]`: which digital output switches what.

    Attributes:
        speed: Outputs that select the drive's speed as a binary number, lowest bit first.
        inverted: Those that are "on" when the output is off; never the lasers and the motor, which must be off
            when the module has no power.
    """

    laser_right: Channel
    laser_left: Channel
    motor_run: Channel
    motor_reverse: Channel
    speed: Annotated[tuple[Channel, ...], BeforeValidator(tuple_from_list), Field(max_length=3)] = ()
    lamp: Channel | None = None
    buzzer: Channel | None = None
    inverted: Annotated[
        tuple[Literal["motor_reverse", "speed", "lamp", "buzzer"], ...], BeforeValidator(tuple_from_list)
    ] = ()

    @property
    def channels(self) -> dict[str, int]:
        """Every wired output by name; the speed bits as speed0, speed1, ..."""
        single = {name: getattr(self, name) for name in ("laser_right", "laser_left", "motor_run", "motor_reverse")}
        extra = {name: getattr(self, name) for name in ("lamp", "buzzer") if getattr(self, name) is not None}
        return single | extra | {f"speed{bit}": channel for bit, channel in enumerate(self.speed)}


class InputWiringModel(Strict):
    """`[devices.io.inputs]`: which digital input reads what.

    Attributes:
        estop_ok: The emergency stop's monitoring contact: closed = all is well.
        home: The home switch: closed while the head is beyond it.
        button: The start/stop button: closed while pressed.
        inverted: Those that read 0 when their contact is closed (a dry contact that pulls the input to ground).
    """

    estop_ok: Channel
    home: Channel
    button: Channel | None = None
    inverted: Annotated[tuple[Literal["estop_ok", "home", "button"], ...], BeforeValidator(tuple_from_list)] = ()

    @property
    def channels(self) -> dict[str, int]:
        """Every wired input by name."""
        named = {"estop_ok": self.estop_ok, "home": self.home}
        return named if self.button is None else named | {"button": self.button}


class AdamModel(Strict):
    """A digital I/O module that speaks ADAM's or DCON's ASCII protocol.

    Attributes:
        dialect: Which module.
        port: /dev/serial/by-id/..., usb:SERIAL, or "emulated".
        baud: As set in the module (factory 9600).
        address: As set in the module (factory 1).
        checksum: As set in the module; recommended, for the plain protocol has nothing against garbled replies.
        reply_timeout_s: How long an answer may take beyond the time on the wire.
    """

    kind: Literal["adam"]
    dialect: Dialect
    port: PortName
    baud: Literal[9600, 19200, 38400, 57600, 115200] = 115200
    address: int = Field(default=1, ge=0, le=255)
    checksum: bool = False
    reply_timeout_s: float = Field(default=0.06, ge=0.01, le=1)
    outputs: OutputWiringModel
    inputs: InputWiringModel

    @property
    def watchdog(self) -> Literal["adam", "dcon"]:
        """Whose watchdog commands it understands."""
        return "adam" if self.dialect.startswith("adam") else "dcon"

    @property
    def terminals(self) -> Terminals:
        """Of this module."""
        return TERMINALS[self.dialect]

    @model_validator(mode="after")
    def _wirable(self) -> "AdamModel":
        for mistake in self._mistakes():
            raise ValueError(mistake)
        return self

    def _mistakes(self) -> Iterator[str]:
        for kind, channels, count in (
            ("output", self.outputs.channels, self.terminals.outputs),
            ("input", self.inputs.channels, self.terminals.inputs),
        ):
            for name, channel in channels.items():
                if channel >= count:
                    yield f"{name} is on {kind} {channel}, {self.dialect} has {kind}s 0 to {count - 1}"
            for channel in channels.values():
                sharing = [name for name, other in channels.items() if other == channel]
                if len(sharing) > 1:
                    yield f"{' and '.join(sharing)} share {kind} {channel}, give each its own"
        unwired = set(self.outputs.inverted) & {"speed", "lamp", "buzzer"} - _wired(self.outputs)
        if unwired:
            yield f"inverted names outputs that are not wired: {', '.join(sorted(unwired))}"


def _wired(outputs: OutputWiringModel) -> set[str]:
    return {name.rstrip("0123456789") for name in outputs.channels}
