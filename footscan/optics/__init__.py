"""Camera, head, light planes and calibration tables (paper, section 3, 4 and appendix)."""

from footscan.optics.calibration import Calibration, EncoderScale, Pose, fingerprint
from footscan.optics.camera import Camera
from footscan.optics.head import Head
from footscan.optics.sheet import LightPlane
from footscan.optics.tables import LightTable, build_table

__all__ = [
    "Calibration",
    "Camera",
    "EncoderScale",
    "Head",
    "LightPlane",
    "LightTable",
    "Pose",
    "build_table",
    "fingerprint",
]
