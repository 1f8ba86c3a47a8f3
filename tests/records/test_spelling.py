import unicodedata
from datetime import date

import pytest
from hypothesis import given
from hypothesis import strategies as st

from footscan.errors import InputError
from footscan.records.spelling import born_from_text, check_born, clean_name, clean_notes, key_of_name, search_key

TODAY = date(2026, 11, 23)
LETTERS = st.text(st.characters(categories=("L", "M", "N", "Zs", "P")), min_size=1, max_size=60)


@given(st.text(max_size=300))
def test_any_text_is_either_a_clean_name_or_refused_in_one_sentence(text):
    try:
        name = clean_name(text)
    except InputError as err:
        assert "\n" not in str(err)
        assert len(str(err)) < 250
        return

    assert name == unicodedata.normalize("NFC", name) == clean_name(name)
    assert name == " ".join(name.split())
    assert not any(unicodedata.category(mark) in ("Cc", "Cs", "Zl", "Zp") for mark in name)
    assert 0 < len(name) <= 200
    assert name.encode()


@given(LETTERS)
def test_letters_of_every_script_are_a_name_unchanged_but_for_spaces_and_composition(text):
    plain = " ".join(unicodedata.normalize("NFC", text).split())
    if any(unicodedata.category(mark)[0] in "LN" for mark in plain):
        assert clean_name(text) == plain


@pytest.mark.parametrize(
    "name", ["José Álvarez", "李小龍", "Αλέξης", "محمد", "ירון", "ณัฐ", "O'Neill-Ødegård", "김 민준", "X Æ 12"]
)
def test_names_of_the_world_stay_as_they_are(name):
    assert clean_name(name) == name


@pytest.mark.parametrize("name", ["", "  ", "a\x00b", "a\nb", "a\tb", "x" * 201, "\u202ea", "a\ud800", "- -", "\u200d"])
def test_what_is_no_name_is_refused(name):
    with pytest.raises(InputError):
        clean_name(name)


@given(LETTERS)
def test_case_and_composition_do_not_make_another_name(text):
    assert key_of_name(unicodedata.normalize("NFD", text)) == key_of_name(unicodedata.normalize("NFC", text))
    assert key_of_name(key_of_name(text)) == key_of_name(text)


@pytest.mark.parametrize(
    ("name", "typed"),
    [("José", "jose"), ("Łódź", "lodz"), ("STRASSE", "straße"), ("Ødegård", "odegard"), ("ｱﾅ", "アナ")],
)
def test_search_needs_no_accents(name, typed):
    assert search_key(name) == search_key(typed)


@given(st.text(max_size=100))
def test_search_takes_any_text(text):
    assert search_key(search_key(text)) == search_key(text)


@given(st.dates())
def test_a_birth_date_is_from_1900_to_today(born):
    if date(1900, 1, 1) <= born <= TODAY:
        assert check_born(born, TODAY) == born_from_text(born.isoformat()) == born
    else:
        with pytest.raises(InputError, match="1900-01-01 to today, 2026-11-23"):
            check_born(born, TODAY)


@pytest.mark.parametrize("text", ["1990-02-30", "31.12.1990", "1990-13-01", "", "19900101", "1990-W01-1", "yesterday"])
def test_what_no_calendar_has_is_no_birth_date(text):
    with pytest.raises(InputError, match="such as 1962-03-31"):
        born_from_text(text)


def test_notes_keep_their_lines_and_refuse_other_control_characters():
    assert clean_notes(" one\r\n\ttwo ") == "one\n\ttwo"
    with pytest.raises(InputError, match=r"U\+0007"):
        clean_notes("bell\x07")
