"""What stands around a table, real or not: world, camera, perception, object, and how a push is laid out."""
