"""The head of the page leaves the tabs all the height it does not need itself."""

from dataclasses import replace

from footscan.gui.panel_machine import head_px
from footscan.gui.state import Job
from footscan.scanning.session.states import Snapshot, State

_REST = Snapshot(State.PARKED, "step on")


def test_whatever_is_shown_more_makes_the_head_higher() -> None:
    rest = head_px(_REST, None, 1)
    higher = (
        head_px(_REST, Job("scanning"), 1),
        head_px(_REST, None, 2),
        head_px(replace(_REST, lasers=("right",)), None, 1),
        head_px(replace(_REST, armed=True), None, 1),
        head_px(replace(_REST, estop_ok=False), None, 1),
        head_px(
            replace(_REST, message="a long sentence about what went wrong and what is to be done about it"), None, 1
        ),
    )

    assert all(px > rest + 20.0 for px in higher)


def test_an_endless_message_leaves_room_for_the_tabs() -> None:
    worst = replace(_REST, state=State.FAULT, message="x" * 5000, lasers=("right", "left"), armed=True, estop_ok=False)

    assert head_px(worst, Job("scanning"), 2) < 600.0
