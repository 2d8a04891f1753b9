"""Folders of many runs: their names, their list, what becomes of each."""
