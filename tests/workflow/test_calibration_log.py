"""The history of calibrations: what is kept, what is said before a scan, and what a power cut leaves."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from footscan.config import load_calibration
from footscan.errors import InputError
from footscan.optics.calibration import Calibration, fingerprint
from footscan.workflow.calibration_log import (
    doubts,
    in_force_path,
    keep_in_force,
    log_event,
    log_path,
    log_service,
    machines,
    note_scan,
    read_log,
    reminders,
    zone_trends,
)

_NOW = datetime(2026, 11, 24, tzinfo=UTC)


@pytest.fixture
def made(ideal: Calibration) -> Calibration:
    return replace(ideal, machine_id="m-1", created=(_NOW - timedelta(days=3)).isoformat())


def _report(machine: Calibration, median_mm: float, moved: bool | None = False) -> dict[str, Any]:
    return {
        "motion": {"zones": [{"zone": "heel", "moved": moved}]},
        "agreement": [{"zone": "heel", "median_mm": median_mm}, {"zone": "toes", "median_mm": None}],
        "calibration": {"sha256": fingerprint(machine)},
        "recording": "somewhere",
    }


def test_a_calibration_in_force_is_kept_with_its_tables_and_logged(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {"expected_error_mm": {"right": 0.01}}, {})
    later = replace(made, latency_s=0.01)
    keep_in_force(tmp_path, later, {}, {})

    assert load_calibration(in_force_path(tmp_path, "m-1")) == later
    assert in_force_path(tmp_path, "m-1").with_suffix(".tables.npz").is_file()
    assert {load_calibration(path) for path in (tmp_path / "calibrations" / "m-1").glob("*.toml")} == {made, later}
    assert [event["sha256"] for event in read_log(tmp_path, "m-1")] == [fingerprint(made), fingerprint(later)]
    assert machines(tmp_path) == ["m-1"]


def test_a_fresh_calibration_needs_no_reminder(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})

    assert reminders(made, read_log(tmp_path, "m-1"), _NOW) == []


def test_age_and_interventions_are_reminded_of(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})
    log_event(tmp_path, "m-1", "service", {"what": "new left laser"})
    said = reminders(made, read_log(tmp_path, "m-1"), _NOW + timedelta(days=400))

    assert "403 days old" in said[0]
    assert "new left laser" in said[1]


def test_an_intervention_before_the_calibration_does_not_matter(tmp_path: Path, made: Calibration):
    log_event(tmp_path, "m-1", "service", {"what": "new left laser"})
    keep_in_force(tmp_path, made, {}, {})

    assert reminders(made, read_log(tmp_path, "m-1"), _NOW) == []


def test_drift_of_the_lasers_over_still_scans_is_said_and_moving_feet_do_not_count(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})
    for k in range(12):
        assert note_scan(tmp_path, "m-1", _report(made, 0.02 if k < 6 else 0.3))
        assert not note_scan(tmp_path, "m-1", _report(made, 5.0, moved=True))
        assert not note_scan(tmp_path, "m-1", _report(made, 5.0, moved=None))
    events = read_log(tmp_path, "m-1")

    assert [len(trend.median_mm) for trend in zone_trends(events)] == [12]
    assert "drift apart at the heel by +0.28 mm" in reminders(made, events, _NOW)[0]


def test_a_line_cut_by_a_power_failure_is_left_out_and_a_damaged_one_is_refused(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})
    path = log_path(tmp_path, "m-1")
    path.write_text(path.read_text() + '{"at": "2026')

    assert len(read_log(tmp_path, "m-1")) == 1
    path.write_text('{"at": "2026\n' + path.read_text())
    with pytest.raises(InputError, match="line 1 is no event"):
        read_log(tmp_path, "m-1")


def test_a_machine_name_that_is_a_path_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="file name"):
        log_event(tmp_path, "../m", "service", {})


def test_a_renewed_part_is_valid_again_and_the_others_stay_invalid(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})
    log_service(tmp_path, "m-1", "right-laser", "")
    log_service(tmp_path, "m-1", "footboard", "planed")
    renewed = replace(made, latency_s=0.02)
    keep_in_force(tmp_path, renewed, {}, {"renewed": "right-laser"})
    open_ = doubts(renewed, read_log(tmp_path, "m-1"), _NOW)

    assert [(doubt.blocking, "planed" in doubt.sentence) for doubt in open_] == [(True, True)]
    keep_in_force(tmp_path, made, {}, {})
    assert doubts(made, read_log(tmp_path, "m-1"), _NOW) == []


def test_a_passed_check_clears_a_moved_machine_but_no_new_lens(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})
    log_service(tmp_path, "m-1", "moved", "")
    log_service(tmp_path, "m-1", "lens", "")
    before = doubts(made, read_log(tmp_path, "m-1"), _NOW)
    log_event(tmp_path, "m-1", "recheck", {"holds": True})
    after = doubts(made, read_log(tmp_path, "m-1"), _NOW)

    assert sorted(doubt.blocking for doubt in before) == [False, True]
    assert [doubt.blocking for doubt in after] == [True]


def test_a_failed_check_blocks_until_one_passes(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})
    log_event(tmp_path, "m-1", "daily", {"holds": False, "broken": ["PS +0.5 mm"]})
    failed = doubts(made, read_log(tmp_path, "m-1"), _NOW)
    log_event(tmp_path, "m-1", "daily", {"holds": True})

    assert [doubt.blocking for doubt in failed] == [True]
    assert "PS +0.5 mm" in failed[0].sentence
    assert doubts(made, read_log(tmp_path, "m-1"), _NOW) == []


def test_an_intervention_at_an_unknown_part_is_refused(tmp_path: Path):
    with pytest.raises(InputError, match="right-laser"):
        log_service(tmp_path, "m-1", "cable", "")


def test_what_was_recorded_before_an_intervention_does_not_come_into_force(tmp_path: Path, made: Calibration):
    recorded_at = datetime.now(UTC).isoformat(timespec="seconds")
    keep_in_force(tmp_path, made, {"recorded_at": recorded_at}, {})
    log_path(tmp_path, "m-1").write_text(
        log_path(tmp_path, "m-1").read_text()
        + '{"at": "2099-01-01T00:00:00+00:00", "kind": "service", "part": "left-laser", "what": "new diode"}\n'
    )

    with pytest.raises(InputError, match=r"before the intervention noted at 2099-01-01.*new diode"):
        keep_in_force(tmp_path, replace(made, latency_s=0.01), {"recorded_at": recorded_at}, {"renewed": "left-laser"})
    assert load_calibration(in_force_path(tmp_path, "m-1")) == made


def test_a_check_recorded_before_the_machine_was_moved_says_nothing_about_it(tmp_path: Path, made: Calibration):
    keep_in_force(tmp_path, made, {}, {})
    log_service(tmp_path, "m-1", "moved", "")
    log_event(tmp_path, "m-1", "recheck", {"holds": True, "recorded_at": "2020-01-01T00:00:00+00:00"})
    before = doubts(made, read_log(tmp_path, "m-1"), _NOW)
    log_event(tmp_path, "m-1", "recheck", {"holds": True, "recorded_at": "2099-01-01T00:00:00Z"})

    assert [doubt.sentence.split("; ")[0][12:] for doubt in before] == ["machine moved"]
    assert doubts(made, read_log(tmp_path, "m-1"), _NOW) == []
