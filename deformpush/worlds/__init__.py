"""What may stand behind the `World` contract; each engine is known in its own folder only."""
