"""`footscan emulate`, typed to."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from footscan import app as rig_app
from footscan.cli.main import app
from footscan.config import load_calibration
from footscan.config.io_models import AdamModel
from footscan.config.rig_file import load_rig
from footscan.errors import ConfigError, StorageError
from footscan.workflow.designs import builtin_config


def test_typed_faults_are_obeyed_and_a_mistyped_one_names_those_there_are(tmp_path: Path):
    typed = "state\ninject explosion\ninject io-unplugged\n\nend\n"
    result = CliRunner().invoke(app, ["emulate", "--links", str(tmp_path / "machine")], input=typed)

    assert result.exit_code == 0
    assert result.stdout.count("the motor is off") == 3
    assert "'explosion' is no fault; there are camera-unplugged" in result.stderr


def test_the_written_rig_file_is_a_machine_with_the_emulators_ports(tmp_path: Path):
    result = CliRunner().invoke(app, ["emulate", "--links", str(tmp_path / "machine")], input="end\n")
    rig = load_rig(tmp_path / "machine" / "rig.toml")

    assert rig.devices.world is None
    assert not rig.devices.emulated
    assert isinstance(rig.devices.io, AdamModel)
    assert rig.devices.io.port == str(tmp_path / "machine" / "io")
    assert str(tmp_path / "machine" / "encoder") in result.stdout
    assert load_calibration(tmp_path / "machine" / "calibration.toml").machine_id == rig.scanner.machine_id


def test_a_rig_without_emulated_devices_is_refused():
    result = CliRunner().invoke(app, ["emulate", "--rig", str(builtin_config("sim"))])

    assert isinstance(result.exception, ConfigError)
    assert "emulated" in str(result.exception)


def test_a_second_machine_in_the_same_folder_is_refused(tmp_path: Path):
    rig = load_rig(builtin_config("rig-emulated"))
    with (
        rig_app.serve_emulators(rig, tmp_path / "machine"),
        pytest.raises(StorageError, match="another machine is served"),
        rig_app.serve_emulators(rig, tmp_path / "machine"),
    ):
        pass

    assert not list((tmp_path / "machine").glob("io"))
