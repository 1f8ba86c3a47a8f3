"""What was done with a patient's records is read on the page: who, what from, what to, and why."""

import html
from datetime import UTC, datetime

from hypothesis import given
from hypothesis import strategies as st

from footscan.gui.binding import plain
from footscan.gui.history import changes_words, history_html
from footscan.records import AuditEntry

WAS = {"patient": 3, "side": "left", "load": "bipedal", "surface": "bare", "in_use": True}


def test_a_correction_says_what_it_changed_from_and_to() -> None:
    now = WAS | {"patient": 4, "side": "right", "load": "seated", "in_use": False}
    words = changes_words({"before": WAS, "after": now})

    assert "patient #3 → #4" in words and "foot left → right" in words
    assert "load standing on both feet → seated" in words and "in use yes → no" in words
    assert "skin" not in words
    assert changes_words({"landmark": "navicular"}) == "" == changes_words({"before": WAS, "after": WAS})
    assert changes_words({"verdict": "with_remark"}) == ": with remark"


def test_who_and_why_stand_in_the_line_and_nothing_typed_is_taken_for_html() -> None:
    entry = AuditEntry(
        7, datetime(2026, 3, 2, 12, tzinfo=UTC), "Dr <b>", "take corrected", 3, "take 9", "swapped & mixed", {}
    )
    words = history_html([entry])

    assert "2026-03-02" in words and "Dr &lt;b&gt;: take corrected, take 9" in words
    assert "<i>(swapped &amp; mixed)</i>" in words


@given(st.text(st.characters(exclude_categories=("C",))))
def test_no_sign_of_a_name_means_anything_to_markdown_and_every_one_is_shown(name: str) -> None:
    shown = plain(name)

    assert html.unescape(shown) == name
    assert not set("*_`[]<>()!|~$\\{}\n").intersection(shown)
