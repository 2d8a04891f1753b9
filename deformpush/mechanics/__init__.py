"""Geometry, meshes, materials and quasi-static pushing: numpy and scipy only."""
