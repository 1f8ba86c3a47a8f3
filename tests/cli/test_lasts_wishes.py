"""Wishes for a pair say which foot they are for."""

import pytest

from footscan.cli.lasts_wishes import check_sides, girth_from_text, of_side, pin_from_text, stack_from_text
from footscan.errors import InputError


def test_wishes_with_a_side_are_for_that_foot_alone():
    said = ["left:ball_girth=245", "right:ball_girth=251", "waist_girth=240"]
    check_sides(said, each_needs_one=False)

    assert dict(map(girth_from_text, of_side(said, "left"))) == {"ball_girth": 245.0, "waist_girth": 240.0}
    assert dict(map(girth_from_text, of_side(said, "right"))) == {"ball_girth": 251.0, "waist_girth": 240.0}


@pytest.mark.parametrize("text", ["1,2,3,4,5", "both:1,2,3,4,5"])
def test_a_place_on_one_foot_needs_its_side(text: str):
    with pytest.raises(InputError, match="left:"):
        check_sides([text], each_needs_one=True)


def test_numbers_that_are_none_are_refused():
    with pytest.raises(InputError, match="5 numbers"):
        pin_from_text("1,2,3")
    with pytest.raises(InputError, match="0 to 30 mm"):
        stack_from_text("3,3,3,99")
