"""Anatomy: arrays and meshes in, arrays and meshes out."""
