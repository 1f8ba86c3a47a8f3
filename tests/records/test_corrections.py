import pytest

from footscan.errors import InputError
from footscan.records import Correction, FootFacts


def test_a_wrong_side_and_load_are_put_right_and_the_result_is_stale(store, ana, file_scan):
    take = file_scan(ana)
    right = store.correct_take(take.id, Correction(side="right", load="bipedal"), "mixed up", "op")
    entry = store.audit(ana.id)[0]

    assert (right.said.side, right.said.load, right.stale) == ("right", "bipedal", True)
    assert (entry.action, entry.reason) == ("take corrected", "mixed up")
    assert (entry.detail["before"]["side"], entry.detail["after"]["side"]) == ("left", "right")
    assert right.recording_sha256 == take.recording_sha256


def test_a_wrong_patient_is_put_right_without_a_new_result_and_both_logs_say_so(store, ana, bo, file_scan):
    take = file_scan(ana)
    store.declare_foot(take.visit_id, "left", FootFacts(deformity="bunion"), "op")
    moved = store.correct_take(take.id, Correction(patient_id=bo.id), "other file open", "op")

    assert (moved.patient_id, moved.stale) == (bo.id, False)
    assert store.visits(ana.id) == []
    assert store.feet(moved.visit_id)[0].facts.deformity == "bunion"
    assert [store.audit(patient.id)[0].action for patient in (ana, bo)] == ["take moved away", "take corrected"]


def test_only_the_take_moves_when_the_foot_has_others(store, ana, file_scan):
    first, second = file_scan(ana, 1), file_scan(ana, 2)
    store.declare_foot(first.visit_id, "left", FootFacts(missing=("toe_1",)), "op")
    moved = store.correct_take(second.id, Correction(side="right"), "mixed up", "op")

    assert (moved.number, moved.missing) == (1, ())
    assert store.take(first.id).missing == ("toe_1",)


def test_a_moved_take_does_not_push_another_out_of_use(store, ana, file_scan):
    left, right = file_scan(ana, 1), file_scan(ana, 2, side="right")
    store.use_take(left.id, "op")
    store.use_take(right.id, "op")
    moved = store.correct_take(left.id, Correction(side="right"), "mixed up", "op")

    assert (moved.in_use, moved.number) == (False, 2)
    assert store.take(right.id).in_use
    assert store.correct_take(right.id, Correction(side="left"), "mixed up", "op").in_use


def test_a_load_in_use_elsewhere_takes_the_mark_away(store, ana, file_scan):
    seated, standing = file_scan(ana, 1), file_scan(ana, 2, load="bipedal")
    store.use_take(seated.id, "op")
    store.use_take(standing.id, "op")

    assert not store.correct_take(seated.id, Correction(load="bipedal"), "stood", "op").in_use
    assert store.take(standing.id).in_use


@pytest.mark.parametrize(
    ("right", "reason", "words"),
    [
        (Correction(side="left"), "x", "already so"),
        (Correction(), "x", "already so"),
        (Correction(side="right"), " ", "the reason is empty"),
        (Correction(patient_id=99), "x", "there is no patient 99"),
        (Correction(side="middle"), "x", "the side is 'middle'; allowed are"),
        (Correction(load="flying"), "x", "the load is 'flying'; allowed are unknown, unloaded"),
        (Correction(surface="fur"), "x", "the surface is 'fur'"),
    ],
)
def test_a_correction_that_is_none_changes_nothing(store, ana, file_scan, right, reason, words):
    take = file_scan(ana)
    log = store.audit()
    with pytest.raises(InputError, match=words):
        store.correct_take(take.id, right, reason, "op")

    assert store.take(take.id) == take
    assert store.audit() == log
