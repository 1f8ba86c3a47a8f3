"""Checks of what people type: names in any script, dates of birth, numbers, reasons."""

import re
import unicodedata
from datetime import date

from footscan.errors import InputError

NAME_LIMIT = 200
NUMBER_LIMIT = 64
LINE_LIMIT = 500
NOTES_LIMIT = 5000
FIRST_BIRTH = date(1900, 1, 1)
_WHOLE_LETTERS = str.maketrans(
    {"ł": "l", "ø": "o", "đ": "d", "ð": "d", "þ": "th", "æ": "ae", "œ": "oe", "ħ": "h", "ı": "i"}
)
"""Letters that a keyboard of another country lacks and Unicode does not take apart."""
_TURNS_TEXT = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Marks that reorder what is beside them: a name with one could make a list show another name."""


def clean_name(text: str) -> str:
    """A patient's name: NFC, single spaces, no space around.

    Raises:
        InputError: Empty, too long, or with a character that is no part of a name.
    """
    name = clean_line(text, "the name", NAME_LIMIT)
    if not any(unicodedata.category(mark)[0] in "LN" for mark in name):
        raise InputError("the name has no letter; enter a name in any script, or a number in its place.")
    return name


def clean_line(text: str, what: str, limit: int = LINE_LIMIT) -> str:
    """One line of text: NFC, single spaces, no space around; may be empty.

    Raises:
        InputError: Too long, or with control characters.
    """
    _refuse_marks(text, what, allowed="")
    return _limited(" ".join(unicodedata.normalize("NFC", text).split()), what, limit)


def clean_notes(text: str, what: str = "the notes") -> str:
    """Text that may have lines and tabs.

    Raises:
        InputError: Too long, or with other control characters.
    """
    text = text.replace("\r\n", "\n")
    _refuse_marks(text, what, allowed="\n\t")
    return _limited(unicodedata.normalize("NFC", text).strip(), what, NOTES_LIMIT)


def needed(text: str, what: str) -> str:
    """One line that must not be empty, such as the reason of a correction or who does it.

    Raises:
        InputError: Empty, too long, or with control characters.
    """
    line = clean_line(text, what)
    if not line:
        raise InputError(f"{what} is empty; it is kept in the log, so it must be said.")
    return line


def check_word(value: str, allowed: tuple[str, ...], what: str) -> None:
    """One of a few words, such as a side or a load.

    Raises:
        InputError: Another word.
    """
    if value not in allowed:
        raise InputError(f"{what} is {value!r}; allowed are {', '.join(allowed)}.")


def clean_number(text: str | None) -> str | None:
    """The clinic's own number of a patient; None when there is none.

    Raises:
        InputError: Too long, or with control characters.
    """
    return None if text is None else clean_line(text, "the patient's own number", NUMBER_LIMIT) or None


def check_born(born: date | None, today: date) -> date | None:
    """A possible date of birth.

    Raises:
        InputError: In the future, or before 1900.
    """
    if born is not None and not FIRST_BIRTH <= born <= today:
        raise InputError(
            f"the date of birth is {born.isoformat()}; allowed is {FIRST_BIRTH.isoformat()} to today, "
            f"{today.isoformat()}. Look at the year."
        )
    return born


def born_from_text(text: str) -> date:
    """A date like 1962-03-31.

    Raises:
        InputError: Not a date, or one that no calendar has.
    """
    try:
        if re.fullmatch("[0-9]{4}-[0-9]{2}-[0-9]{2}", text) is None:
            raise ValueError
        return date.fromisoformat(text)
    except ValueError:
        raise InputError(
            f"the date of birth is {text!r}; a date of the calendar as year-month-day is needed, such as 1962-03-31."
        ) from None


def key_of_name(name: str) -> str:
    """Two names with the same key are taken for the same name."""
    return " ".join(unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", name).casefold()).split())


def search_key(text: str) -> str:
    """A name as it is searched: without case, accents and other marks (José is found by jose, Łódź by lodz)."""
    apart = unicodedata.normalize("NFKD", key_of_name(text))
    plain = "".join(mark for mark in apart if not unicodedata.combining(mark)).casefold()
    return " ".join(unicodedata.normalize("NFC", plain.translate(_WHOLE_LETTERS)).split())


def _refuse_marks(text: str, what: str, allowed: str) -> None:
    for mark in text:
        if mark in allowed:
            continue
        if unicodedata.category(mark) in ("Cc", "Cs", "Zl", "Zp") or mark in _TURNS_TEXT:
            raise InputError(
                f"{what} holds the control character U+{ord(mark):04X}; letters of any script, digits, punctuation and "
                "spaces are allowed. Type it again instead of pasting it."
            )


def _limited(text: str, what: str, limit: int) -> str:
    if len(text) > limit:
        raise InputError(f"{what} has {len(text)} characters, at most {limit} are kept; shorten it.")
    return text
