"""What a simulated picture is made with: light, surfaces, sensor."""

from dataclasses import dataclass, replace


@dataclass(frozen=True)
class PictureSettings:
    """Light, surfaces and sensor.

    Attributes:
        laser_distance_mm: From the axis, along the sheet.
        laser_height_mm: Above the board.
        sheet_sigma_mm: Half width of the sheet (standard deviation) on a surface facing it.
        layers: Thin sheets the sheet is made of: 1, or at least 5.
        skin_grey: Grey value of laser light on skin that faces the laser at the axis, before the blur.
        board_grey: The same for the footboard.
        spread_share: Share of the light that comes back from inside the skin.
        spread_mm: How far (standard deviation).
        blur_px: Blur of the lens and of the pixels' own width (standard deviation).
        ambient_skin_grey: Ambient light on skin facing the lamps above; a third of it where turned away.
        ambient_board_grey: Ambient light on the board.
        board_radius_mm: Radius of the round footboard.
        speckle: Standard deviation of laser light relative to itself, per pixel.
        electrons_per_grey: For shot noise.
        read_noise_grey: Standard deviation.
        black_level: Smaller grey values are written as 0.
        exposure: Of the shutter, relative: more light, more of its shot noise, the same read noise.
        gain: Of the camera: light, shot noise and read noise alike. Above 255 everything is 255.
    """

    laser_distance_mm: float = 560.0
    laser_height_mm: float = 375.0
    sheet_sigma_mm: float = 0.35
    layers: int = 5
    skin_grey: float = 400.0
    board_grey: float = 175.0
    spread_share: float = 0.06
    spread_mm: float = 1.2
    blur_px: float = 0.7
    ambient_skin_grey: float = 17.0
    ambient_board_grey: float = 7.0
    board_radius_mm: float = 300.0
    speckle: float = 0.10
    electrons_per_grey: float = 60.0
    read_noise_grey: float = 1.2
    black_level: int = 16
    exposure: float = 1.0
    gain: float = 1.0

    def __post_init__(self) -> None:
        if not (self.exposure > 0.0 and self.gain > 0.0):
            raise ValueError(f"exposure and gain are positive, found {self.exposure:g} and {self.gain:g}")


DEFAULT_PICTURE = PictureSettings()


def without_noise(settings: PictureSettings = DEFAULT_PICTURE) -> PictureSettings:
    """The same light on a perfect sensor and without speckle, ambient light and spread: for checks of the geometry."""
    return replace(
        settings,
        spread_share=0.0,
        ambient_skin_grey=0.0,
        ambient_board_grey=0.0,
        speckle=0.0,
        electrons_per_grey=0.0,
        read_noise_grey=0.0,
        black_level=0,
    )
