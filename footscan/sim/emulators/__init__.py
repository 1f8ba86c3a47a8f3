"""Emulators that speak the real bytes of real devices over a pseudo terminal, driven by a small object each."""
