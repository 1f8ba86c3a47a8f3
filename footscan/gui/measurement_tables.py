"""Measurements as tables: on the page, with definitions on hover; as CSV; before and after smoothing."""

import csv
import html
import io
from collections.abc import Mapping
from typing import Any

from footscan.gui import texts

_TABLE = '<table style="width:100%;text-align:left;font-size:12.5px;border-spacing:0 1px">{rows}</table>'
_NAMED = "vertical-align:top;text-decoration:underline dotted #999;cursor:help"


def measurement_table(measurements: Mapping[str, Mapping[str, Any]]) -> str:
    """All measurements with intervals and marks; the definition is shown on hover."""
    meanings = _definitions()
    rows = "".join(_row(name, value, meanings.get(name, "")) for name, value in measurements.items())
    return _TABLE.format(rows=texts.MEASURE_HEAD + rows) + f"<div>{texts.MEASURE_MARKS}</div>"


def _row(name: str, value: Mapping[str, Any], meaning: str) -> str:
    interval = value["interval"]
    span = "" if interval is None else f"{interval[0]:.1f} to {interval[1]:.1f}"
    mark = "" if value["reliable"] else f'<span title="{html.escape(str(value["reason"]))}">⚠</span>'
    mark += f'<span title="{html.escape(str(value["unusual"]))}">◆</span>' if value["unusual"] else ""
    words = html.escape(name.replace("_", " "))
    named = f'<td title="{html.escape(meaning)}" style="{_NAMED}">{words}</td>'
    if value["value"] is None:
        return f'<tr>{named}<td colspan="3" style="color:#666">{_why_none(value)}</td></tr>'
    return (
        f'<tr>{named}<td style="white-space:nowrap">{_number(value)}</td><td style="white-space:nowrap">{span}</td>'
        f"<td>{mark}</td></tr>"
    )


def _why_none(value: Mapping[str, Any]) -> str:
    return html.escape(str(value["reason"]).replace("_", " ") or texts.MEASURE_NONE)


def _number(value: Mapping[str, Any]) -> str:
    """With its unit; proportions are small numbers and need more places."""
    return f"{value['value']:.3f}" if value["unit"] == "1" else f"{value['value']:.1f} {value['unit']}"


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
