"""Finite elements in MuJoCo: a flex, whose states can be saved to the bit and branched."""
