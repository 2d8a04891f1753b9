"""Other ways to choose the next push, under the same ask/tell."""
