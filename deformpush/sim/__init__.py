"""Worlds: Bullet with a soft slab, arm or bare tool, and a toy without an engine."""
