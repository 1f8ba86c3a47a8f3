"""To which pitches a foot may be bent: near the one it was scanned on, the flat board or a wedge."""

from footscan.shoelast.prepared_foot import PreparedFoot

MOST_BENT_MM = 35.0
"""A foot scanned flat is bent to at most this pitch."""
MOST_FROM_WEDGE_MM = 15.0
"""A foot scanned on a wedge is bent to pitches that differ from the wedge's height by at most this."""


def wedge_mm(foot: PreparedFoot) -> float:
    """Height of the wedge on which a foot was scanned; 0 on the flat board."""
    return 0.0 if foot.wedge is None else foot.wedge.height_mm


def pitch_reason(foot: PreparedFoot, pitch_mm: float) -> str:
    """Why a foot may not be bent to a pitch, with what to do; empty when it may.

    Args:
        foot: As scanned.
        pitch_mm: By how much the last with its insole lifts the heel above the ball.
    """
    if foot.wedge is None:
        if abs(pitch_mm) <= MOST_BENT_MM:
            return ""
        return (
            f"the heel is lifted by {pitch_mm:.0f} mm and the foot was scanned on the flat board: such a scan is bent "
            f"by at most {MOST_BENT_MM:.0f} mm. Scan the foot with its heel on a wedge of about {pitch_mm:.0f} mm, or "
            "take a last with a lower pitch"
        )
    wedge = foot.wedge.height_mm
    if abs(pitch_mm - wedge) <= MOST_FROM_WEDGE_MM:
        return ""
    low, high = max(wedge - MOST_FROM_WEDGE_MM, 0.0), wedge + MOST_FROM_WEDGE_MM
    return (
        f"the heel is lifted by {pitch_mm:.0f} mm and the foot was scanned on a wedge of {wedge:.0f} mm: such a scan "
        f"is bent by at most {MOST_FROM_WEDGE_MM:.0f} mm. Take a last with a pitch of {low:.0f} to {high:.0f} mm, or "
        "scan the foot anew"
    )
