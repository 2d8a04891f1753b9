"""Finite elements in PyBullet."""
