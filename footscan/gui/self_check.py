"""Does the page stand? Asked of a page that is being served, as a browser and as a stranger would."""

import http.client
import importlib.util
from collections.abc import Iterator

from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from footscan.errors import QualityError
from footscan.gui import texts
from footscan.gui.door import Address

_WAIT_S = 60.0


def check_page(address: Address) -> Iterator[str]:
    """What was found, sentence by sentence.

    Args:
        address: Where the page is served; its port is the true one.

    Raises:
        QualityError: The page does not stand.
    """
    yield _answers(address)
    yield _refuses_strangers(address)
    yield _renders(address)


def _answers(address: Address) -> str:
    connection = http.client.HTTPConnection(address.host, address.port, timeout=_WAIT_S)
    try:
        connection.request("GET", "/")
        answer = connection.getresponse()
        body = answer.read()
    finally:
        connection.close()
    if answer.status != 200 or b"<html" not in body:
        raise QualityError(f"the page answers with status {answer.status} and {len(body)} bytes; it does not stand.")
    return f"The page answers: {len(body)} bytes."


def _refuses_strangers(address: Address) -> str:
    try:
        connect(f"ws://{address.host}:{address.port}", origin=None, open_timeout=_WAIT_S).close()
    except InvalidStatus as refusal:
        if refusal.response.status_code == 403:
            return "A connection from elsewhere is refused (403)."
        raise QualityError(
            f"a connection from elsewhere gets status {refusal.response.status_code}, not 403."
        ) from refusal
    raise QualityError("a connection from elsewhere was accepted; the machine would not be safe.")


def _renders(address: Address) -> str:
    if importlib.util.find_spec("playwright") is None:
        return "Not looked at in a browser: playwright is not installed (pip install 'footscan[dev]')."
    from footscan.gui.headless import find_chromium, open_chromium

    if find_chromium() is None:
        return "Not looked at in a browser: there is no Chromium (apt-get install chromium)."
    with open_chromium() as browser:
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(f"http://{address.host}:{address.port}", timeout=1000 * _WAIT_S)
        for name in (texts.TAB_PATIENT, texts.TAB_SCAN, texts.TAB_SYSTEM):
            page.get_by_role("tab", name=name, exact=True).wait_for(timeout=1000 * _WAIT_S)
        page.get_by_role("button", name=texts.STOP).wait_for(timeout=1000 * _WAIT_S)
        page.locator("canvas").first.wait_for(timeout=1000 * _WAIT_S)
        page.get_by_text(texts.YOU_CONTROL).wait_for(timeout=1000 * _WAIT_S)
    return "A browser shows it: tabs, STOP, the 3-D view, and it controls the machine."
