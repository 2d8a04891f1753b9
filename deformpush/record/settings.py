"""How much of a run is recorded and shown: the options of the group `record`."""

import re
from dataclasses import dataclass
from typing import Annotated

from annotated_types import Interval

ADDRESS = r"rerun(\+https?)?://(?P<host>[^/:]+):(?P<port>\d{1,5})/proxy"
"""Where a viewer listens."""
RECENT = 100
"""Pushes that marks in the recording go back: the trail of the centroid, the pushes made on the maps."""
SPAWNED = "rerun+http://127.0.0.1:9876/proxy"
"""Where one listens that was started on this machine."""


@dataclass(frozen=True)
class RecordSettings:
    """What is written beside table, contours and summary, which always are."""

    rrd: bool = True
    """Write recording.rrd."""
    scene: bool = True
    """Record the 3D scene: mesh, table, arm or tool."""
    motion: bool = True
    """Record the moments inside each push."""
    maps: bool = True
    """Record mean, sigma and acquisition over (kappa, d)."""
    image_px: Annotated[int, Interval(ge=64, le=2048)] = 480
    """Width of the bottom view in the recording (px)."""
    jpeg_quality: Annotated[int, Interval(ge=10, le=100)] = 85
    figures: bool = True
    """Draw figures/ at the end."""
    world_states: bool = True
    """Keep what the world was after each push, where it can be saved: to resume at once, and for `whatif`."""
    spawn: bool = False
    """Show the run live in a viewer window."""
    connect: str | None = None
    """Show it live in a viewer that listens at this address."""

    def __post_init__(self) -> None:
        if self.connect is not None and not re.fullmatch(ADDRESS, self.connect):
            raise ValueError(
                f"connect: {self.connect!r} is no address of a viewer, such as {SPAWNED} (null for none)"
            )

    @property
    def streams(self) -> bool:
        """Whether there is a recording or a viewer to stream to."""
        return self.rrd or self.spawn or self.connect is not None
