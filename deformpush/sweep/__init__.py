"""Many runs by one command: their folders, what becomes of each, and what is left to do."""
