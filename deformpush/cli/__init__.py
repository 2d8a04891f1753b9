"""The command line: one module a verb, and what happens before Hydra."""
