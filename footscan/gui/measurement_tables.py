"""Measurements as tables: on the page, with definitions on hover; as CSV; before and after smoothing."""

import csv
import html
import io
from collections.abc import Mapping
from typing import Any

from footscan.gui import texts

_TABLE = '<table style="width:100%;text-align:left;font-size:12.5px;border-spacing:0 1px">{rows}</table>'
_NAMED = "text-decoration:underline dotted #999;cursor:help"
_CELL = "white-space:nowrap;padding-right:8px"
_UNITS = {"deg": "°", "cm2": "cm²", "cm3": "cm³"}


def measurement_table(measurements: Mapping[str, Mapping[str, Any]]) -> str:
    """All measurements with intervals and marks; the definition is shown on hover."""
    meanings = _definitions()
    rows = "".join(_row(name, value, meanings.get(name, "")) for name, value in measurements.items())
    return _TABLE.format(rows=texts.MEASURE_HEAD + rows) + f"<div>{texts.MEASURE_MARKS}</div>"


def comparison_table(left: Mapping[str, Mapping[str, Any]], right: Mapping[str, Mapping[str, Any]]) -> str:
    """Both feet beside each other with their difference; marks and definitions as in the table of one foot."""
    meanings = _definitions()
    rows = "".join(_compared(name, left[name], right[name], meanings.get(name, "")) for name in left if name in right)
    return _TABLE.format(rows=texts.COMPARE_HEAD + rows) + f"<div>{texts.COMPARE_NOTE} {texts.MEASURE_MARKS}</div>"


def _compared(name: str, left: Mapping[str, Any], right: Mapping[str, Any], meaning: str) -> str:
    values = left["value"], right["value"]
    difference = "" if None in values else _signed(values[1] - values[0], left["unit"])
    cells = "".join(
        f'<td style="{_CELL}">{texts.COMPARE_NONE if value["value"] is None else _number(value)} {_marks(value)}</td>'
        for value in (left, right)
    )
    return f'<tr>{_name_cell(name, meaning)}{cells}<td style="{_CELL}">{difference}</td></tr>'


def _signed(difference: float, unit: str) -> str:
    places = 3 if unit == "1" else 1
    rounded = round(difference, places)
    return f"{rounded:+.{places}f}".replace("-", "−") if rounded else f"{0.0:.{places}f}"


def _marks(value: Mapping[str, Any]) -> str:
    mark = "" if value["reliable"] else f'<span title="{html.escape(str(value["reason"]))}">⚠</span>'
    return mark + (f'<span title="{html.escape(str(value["unusual"]))}">◆</span>' if value["unusual"] else "")


def _name_cell(name: str, meaning: str) -> str:
    words = f'<span title="{html.escape(meaning)}" style="{_NAMED}">{html.escape(name.replace("_", " "))}</span>'
    return f'<td style="padding-right:8px;vertical-align:top">{words}</td>'


def _row(name: str, value: Mapping[str, Any], meaning: str) -> str:
    interval = value["interval"]
    span = "" if interval is None else f"{interval[0]:.1f} to {interval[1]:.1f}"
    named = _name_cell(name, meaning)
    if value["value"] is None:
        return f'<tr>{named}<td colspan="3" style="color:#666">{_why_none(value)}</td></tr>'
    return (
        f'<tr>{named}<td style="{_CELL}">{_number(value)}</td><td style="{_CELL}">{span}</td>'
        f"<td>{_marks(value)}</td></tr>"
    )


def _why_none(value: Mapping[str, Any]) -> str:
    return html.escape(str(value["reason"]).replace("_", " ") or texts.MEASURE_NONE)


def _number(value: Mapping[str, Any]) -> str:
    """With its unit; proportions are small numbers and need more places."""
    return (
        f"{value['value']:.3f}"
        if value["unit"] == "1"
        else f"{value['value']:.1f} {_UNITS.get(value['unit'], value['unit'])}"
    )


def measurements_csv(measurements: Mapping[str, Mapping[str, Any]]) -> bytes:
    """One line per measurement: name, value, unit, interval, whether it is reliable, why not, what is unusual."""
    stream = io.StringIO()
    writer = csv.writer(stream)
    writer.writerow(("name", "value", "unit", "from", "to", "reliable", "reason", "unusual", "definition"))
    meanings = _definitions()
    for name, value in measurements.items():
        low, high = value["interval"] or ("", "")
        number = "" if value["value"] is None else value["value"]
        marks = (value["reliable"], value["reason"], value["unusual"])
        writer.writerow((name, number, value["unit"], low, high, *marks, meanings.get(name, "")))
    return stream.getvalue().encode()


def price_table(words: str, price: Mapping[str, Mapping[str, float]]) -> str:
    """What filtering and smoothing did to the main values."""
    before, after = price["before"], price["after"]
    rows = "".join(
        f"<tr><td>{html.escape(_named(name))}</td><td>{value:.2f}</td><td>{after[name]:.2f}</td>"
        f"<td>{after[name] - value:+.2f}</td></tr>"
        for name, value in before.items()
        if name in after
    )
    return f"<b>{html.escape(words)}</b>{_TABLE.format(rows=texts.PRICE_HEAD + rows)}"


def _named(name: str) -> str:
    """`foot_length` is in millimetres; names that carry a unit keep it."""
    for ending, unit in (("_cm3", "cm³"), ("_mm", "mm")):
        if name.endswith(ending):
            return f"{name.removesuffix(ending).replace('_', ' ')} ({unit})"
    return f"{name.replace('_', ' ')} (mm)"


def _definitions() -> Mapping[str, str]:
    from footscan.foot.measurements import definitions

    return definitions()
