"""What colours mean, in words beside squares of them."""

import html
from collections.abc import Sequence


def legend_html(entries: Sequence[tuple[str, str]]) -> str:
    """Colours as `#rrggbb` with what each means, as HTML; no entry is broken in two."""
    square = "display:inline-block;width:14px;height:14px;border:1px solid #777;vertical-align:-2px;margin-right:5px"
    return "".join(
        f'<span style="display:inline-block;white-space:nowrap;margin-right:14px">'
        f'<span style="{square};background:{colour}"></span>{html.escape(words)}</span>'
        for colour, words in entries
    )
