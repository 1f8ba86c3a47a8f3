"""The laser stripe in one frame: sub-pixel places across the stripe's own direction, whatever it is."""

from footscan.scanning.stripe.find import Stripe, StripeFinder, StripeSettings, find_stripe
from footscan.scanning.stripe.threshold import automatic_threshold, brightness_histogram

__all__ = [
    "Stripe",
    "StripeFinder",
    "StripeSettings",
    "automatic_threshold",
    "brightness_histogram",
    "find_stripe",
]
