"""Everything that is written during and after a run."""
