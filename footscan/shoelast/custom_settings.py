"""How a last is customised: transition, insole, joints, holding, pins and wanted girths."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from footscan.shoelast.fitting_defaults import TRANSITION_MM
from footscan.shoelast.foot_pose import InsoleStack
from footscan.shoelast.foot_pose_joints import Joints
from footscan.shoelast.pins import Pin


@dataclass(frozen=True)
class CustomSettings:
    """How to customise.

    Attributes:
        transition_mm: How far a change may reach beyond the skin that asks for it.
        stack: Insole under the foot.
        joints: What each joint of the foot may do.
        hold: Whether heel sides, waist and instep may lose material where the foot has too much room.
        pins: Spot allowances.
        girths_mm: Wanted tape girths of the last, name -> mm (ball_girth, waist_girth, instep_girth).
        smooth_mm: How far smoothing may move the result, in or out; 0 leaves it as it is.
    """

    transition_mm: float = TRANSITION_MM
    stack: InsoleStack = field(default_factory=InsoleStack)
    joints: Joints = field(default_factory=Joints)
    hold: bool = True
    pins: tuple[Pin, ...] = ()
    girths_mm: Mapping[str, float] = field(default_factory=dict[str, float])
    smooth_mm: float = 0.0
