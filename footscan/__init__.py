"""Software of a laser foot scanner: from video frames to a measured foot and its customised shoelast."""

__version__ = "0.1.0"
