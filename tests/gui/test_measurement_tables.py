"""Tables of measurements: nothing unreliable without its mark, nothing unescaped, the same numbers in the CSV."""

import csv
import io
from typing import Any

from footscan.gui.measurement_tables import comparison_table, measurement_table, measurements_csv, price_table


def _value(value: float | None, *, reliable: bool = True, reason: str = "", unusual: str = "") -> dict[str, Any]:
    interval = None if value is None else [value - 1.0, value + 1.0]
    return {
        "value": value, "unit": "mm", "reliable": reliable, "reason": reason, "interval": interval, "unusual": unusual
    }  # fmt: skip


MEASURED = {
    "foot_length": _value(251.25),
    "ball_girth": _value(231.5, reliable=False, reason='runs on "unseen" <skin>', unusual="wide & high"),
    "toe_1_angle": _value(None, reliable=False, reason="not applicable: toe_1 is <absent>"),
}


def test_what_is_not_reliable_or_unusual_is_marked_with_its_reason() -> None:
    table = measurement_table(MEASURED)
    first, second = table.split("<tr>")[2:4]

    assert "251.2 mm" in first and "250.2 to 252.2" in first and "⚠" not in first
    assert "⚠" in second and "◆" in second
    assert "runs on &quot;unseen&quot; &lt;skin&gt;" in second
    assert "wide &amp; high" in second


def test_what_has_no_value_says_why_in_words_and_not_on_hover_alone() -> None:
    row = measurement_table(MEASURED).split("<tr>")[4].split("</tr>")[0]

    assert ">not applicable: toe 1 is &lt;absent&gt;</td>" in row
    assert "<td>-" not in row and "⚠" not in row


def test_a_proportion_is_shown_with_three_places_and_no_unit() -> None:
    index = _value(0.3148) | {"unit": "1", "interval": None}

    assert ">0.315<" in measurement_table({"height_index": index})


def test_units_are_written_as_people_write_them() -> None:
    table = measurement_table(
        {"toe_1_angle": _value(23.9) | {"unit": "deg"}, "volume": _value(766.8) | {"unit": "cm3"}}
    )

    assert "23.9 °" in table and "766.8 cm³" in table


def test_both_feet_stand_beside_each_other_with_their_difference_and_their_marks() -> None:
    table = comparison_table(MEASURED, {**MEASURED, "foot_length": _value(249.0), "only_here": _value(1.0)})
    length, girth, angle = table.split("<tr>")[2:5]

    assert length.index("251.2 mm") < length.index("249.0 mm") < length.index("−2.2")
    assert girth.count("⚠") == 2 and ">0.0<" in girth
    assert angle.count("none") == 2 and "+" not in angle
    assert "only here" not in table


def test_every_name_carries_its_definition() -> None:
    assert 'title=""' not in measurement_table(MEASURED)


def test_the_csv_holds_every_value_in_full() -> None:
    rows = list(csv.DictReader(io.StringIO(measurements_csv(MEASURED).decode())))

    assert [row["name"] for row in rows] == list(MEASURED)
    assert (rows[0]["value"], rows[0]["from"], rows[0]["reliable"]) == ("251.25", "250.25", "True")
    assert (rows[1]["value"], rows[1]["reason"]) == ("231.5", 'runs on "unseen" <skin>')
    assert (rows[2]["value"], rows[2]["reason"]) == ("", "not applicable: toe_1 is <absent>")


def test_the_price_of_smoothing_is_stated_with_units() -> None:
    price = {
        "before": {"mesh_volume_cm3": 900.0, "foot_length": 250.0},
        "after": {"mesh_volume_cm3": 890.0, "foot_length": 249.5},
    }
    table = price_table("tried", price)

    assert "mesh volume (cm³)" in table and "-10.00" in table
    assert "foot length (mm)" in table and "-0.50" in table
