"""Every error that footscan raises on purpose.

```
FootscanError
|-- InputError                what somebody gave us is unusable          exit status 2
|   |-- ConfigError           a TOML file: key, found, allowed
|   |-- RecordingError        a recording is cut, tampered with or of another kind
|   |-- StaleTableError       a calibration table of another calibration
|   |-- MachineMismatchError  a calibration of another machine
|   |-- MeshError             a mesh or cloud that is no foot
|   |-- RecordsError          the records are foreign, newer, damaged or busy
|   `-- DuplicatePatientError a patient of that name and birth date is already there
|-- StorageError              the disk is full or a place cannot be written  exit status 2
|-- DeviceError               camera, encoder or outputs in trouble      exit status 3
|   |-- CameraLostError       no frame came in time, or the camera is gone
|   |-- EncoderLostError      the encoder is silent, jumps or counts the wrong way
|   |-- OutputsLostError      the module does not answer or does not obey
|   |-- WrongDeviceError      a device answers that is not as the rig file says
|   |   `-- WrongWayError     the head turns against the motor's command
|   |-- HeadStalledError      the motor is on and the head does not turn
|   |-- EmergencyStopError    the emergency stop is open
|   |-- InterlockError        an output was asked for that is not allowed now
|   `-- ThreadFailedError     a thread of the scan has ended unexpectedly
|-- CancelledError            a person has cancelled it
`-- QualityError              a result refused by a quality gate         exit status 4
    |-- EmptyScanError        no laser stripe, or too little of one
    `-- PoorFitError          a calibration whose residuals are too large
```

A message is one sentence or two: what was found, what is allowed, what to do next.
"""


class FootscanError(Exception):
    """Root of the tree; `exit_status` is what the command line returns."""

    exit_status = 2


class InputError(FootscanError):
    """Something given by a person or a file cannot be used."""


class ConfigError(InputError):
    """A TOML file is missing, malformed or holds a value that is not allowed."""


class RecordingError(InputError):
    """A recording is incomplete, tampered with, or of another kind than needed."""


class StaleTableError(InputError):
    """A stored calibration table belongs to another calibration."""


class MachineMismatchError(InputError):
    """A calibration of one machine was offered for a recording of another."""


class MeshError(InputError):
    """A mesh or cloud cannot be understood as a foot."""


class RecordsError(InputError):
    """The records of a data folder are foreign, newer than this program, damaged, or kept busy by another one."""


class DuplicatePatientError(InputError):
    """A patient of the same name and birth date is already kept; a person must say whether it is the same."""


class StorageError(FootscanError):
    """A file could not be written; nothing half-written was left."""


class DeviceError(FootscanError):
    """A camera, encoder or output module is in trouble."""

    exit_status = 3


class CameraLostError(DeviceError):
    """No frame came in time, or the camera is gone."""


class EncoderLostError(DeviceError):
    """The encoder is silent, jumps or counts the wrong way."""


class WrongWayError(EncoderLostError):
    """The head turns against the motor's command, or the encoder counts against it."""


class OutputsLostError(DeviceError):
    """The output module does not answer or does not obey."""


class WrongDeviceError(DeviceError):
    """A device answers, but it is another one, or set up otherwise, than the rig file says."""


class HeadStalledError(DeviceError):
    """The motor is on and the head does not turn as it should."""


class EmergencyStopError(DeviceError):
    """The emergency stop is open."""


class InterlockError(DeviceError):
    """An output was asked for that is not allowed now."""


class StoppedError(InterlockError):
    """The machine was told to stop, by somebody or because nobody watched; nothing is wrong with it."""


class ThreadFailedError(DeviceError):
    """A thread of the scan has ended unexpectedly."""


class QualityError(FootscanError):
    """A result exists but a quality gate refuses it."""

    exit_status = 4


class EmptyScanError(QualityError):
    """A scan shows no laser stripe, or too little of one to be a foot."""


class PoorFitError(QualityError):
    """A calibration whose residuals are larger than allowed.

    Attributes:
        repeat: The placement of the board that is to blame, where repeating it is enough; empty otherwise.
        more: More placements of the board may be enough.
    """

    def __init__(self, sentence: str, repeat: str = "", more: bool = False) -> None:
        super().__init__(sentence)
        self.repeat, self.more = repeat, more


class CancelledError(FootscanError):
    """A person has cancelled what was being done."""
