"""An arm whose tool stands upright: kinematics, postures along a path, its description for a recorder."""
