"""deformpush: pushing thin, fragile, deformable objects to a pose with very few trial pushes."""

__version__ = "0.1.0"
