"""Choosing the optimizer's settings by what they cost in pushes: for the verb `tune`."""
