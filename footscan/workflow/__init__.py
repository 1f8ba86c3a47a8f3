"""One visit end to end, without a screen."""
