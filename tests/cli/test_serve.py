"""`footscan serve`: refusals at once, demo patients, and the check that the page stands."""

import socket
import subprocess
import sys
from pathlib import Path

from typer.testing import CliRunner

from footscan.cli.main import app
from footscan.records import RecordStore
from footscan.workflow.demo_patients import add_demo_patients

runner = CliRunner()


def test_another_host_is_refused_before_anything_is_opened(tmp_path: Path) -> None:
    done = runner.invoke(app, ["serve", "--host", "0.0.0.0", "--data", str(tmp_path / "data")])

    assert "docs/howto/network.md" in str(done.exception)
    assert not (tmp_path / "data").exists()


def test_a_busy_port_is_said_with_the_way_out(tmp_path: Path) -> None:
    with socket.socket() as busy:
        busy.bind(("127.0.0.1", 0))
        busy.listen()
        done = runner.invoke(app, ["serve", "--port", str(busy.getsockname()[1]), "--data", str(tmp_path / "data")])

    assert "--port" in str(done.exception)
    assert not (tmp_path / "data").exists()


def test_the_check_of_a_page_with_demo_patients_ends_well(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "footscan.cli.main", "serve", "--demo", "--check", "--port", "0"]
    done = subprocess.run([*words, "--data", str(tmp_path)], capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stdout + done.stderr
    assert "The page answers" in done.stdout and "refused (403)" in done.stdout
    assert "browser" in done.stdout
    with RecordStore(tmp_path) as store:
        assert len(store.find_patients("", 9)) == 2


def test_demo_patients_are_entered_once_and_never_among_real_ones(tmp_path: Path) -> None:
    with RecordStore(tmp_path) as store:
        for _ in range(2):
            add_demo_patients(store)

        assert [patient.number for patient in store.find_patients("", 9)] == ["DEMO-1", "DEMO-2"]
