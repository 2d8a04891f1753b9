"""What the verb `doctor` examines."""
