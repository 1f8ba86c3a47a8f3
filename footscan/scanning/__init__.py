"""Recordings, stripes, the scan matrix, and the way from frames to a cloud in the world."""
