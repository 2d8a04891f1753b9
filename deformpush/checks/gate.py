"""What a check says."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Gate:
    """One check: what was measured, what is allowed, and whether it holds."""

    name: str
    measured: str
    allowed: str
    passed: bool
