"""The technician reads every result of a drill, also when one case could not be broken, and faults in words."""

from collections.abc import Iterator

from footscan.devices.diagnosis import Finding
from footscan.errors import QualityError
from footscan.gui import texts
from footscan.gui.tab_system import drill_on, drill_table, examined_html
from footscan.workflow.drill_result import DrillResult

CASES = ("encoder silent", "SIGTERM", "disk full")


class OneFails:
    """A drill on a computer that is too busy for the second case."""

    def run(self, cases: tuple[str, ...]) -> Iterator[DrillResult]:
        for case in cases:
            if case == "SIGTERM":
                raise QualityError("the scan ended <before> it was broken.")
            yield DrillResult(case, 0.05, "the encoder is silent", 9, 9, 9, 0)


def test_a_case_that_could_not_be_broken_is_told_and_the_others_are_drilled_all_the_same() -> None:
    results = tuple(drill_on(OneFails(), CASES))  # pyright: ignore[reportArgumentType]
    table = drill_table(results)

    assert [result.case for result in results] == list(CASES)
    assert [result.well for result in results] == [True, False, True]
    assert table.count("0.050 s") == 2 and texts.DRILL_NOT_BROKEN in table
    assert ">the scan ended &lt;before&gt; it was broken.</td>" in table
    assert table.count(">the encoder is silent</td>") == 2
    assert drill_table(()) == ""


def test_a_device_in_trouble_is_named_in_the_words_of_the_trade_with_its_sentence() -> None:
    words = examined_html(Finding("io", "trouble", "no answer at <COM3>; check the cable."))

    assert "outputs" in words and "✖" in words and "no answer at &lt;COM3&gt;; check the cable." in words
