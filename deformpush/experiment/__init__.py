"""A configuration becomes runs, and runs become sweeps."""
