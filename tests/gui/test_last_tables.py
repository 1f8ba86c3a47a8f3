"""Tables of the Last tab say what was found, and nothing a browser would run."""

from footscan.gui import texts
from footscan.gui.last_tables import ranking_table
from footscan.shoelast.last_library import LastEntry
from footscan.shoelast.rank import Ranked


def _ranked(last_id: str, score: float) -> Ranked:
    entry = LastEntry(last_id, f"<b>{last_id}</b>", "left", {})
    return Ranked(entry, score, {"ball_girth": score}, {"ball_girth": -3.04, "length_room": 16.7})


def test_a_ranking_marks_the_chosen_last_and_shows_signed_differences():
    table = ranking_table([_ranked("one", 2.46), _ranked("two", 3.1)], "two")

    rows = table.split("<tr>")[2:]
    assert "▸" not in rows[0] and "▸" in rows[1]
    assert "2.5" in rows[0] and "-3.0" in rows[0] and "+16.7" in rows[0]
    assert "&lt;b&gt;one&lt;/b&gt;" in rows[0]
    assert texts.LAST_RANKING_NOTE in table


def test_no_ranking_is_no_table():
    assert ranking_table([], "") == ""
