"""What the address of a viewer looks like."""

ADDRESS = r"rerun(\+https?)?://(?P<host>[^/:]+):(?P<port>\d{1,5})/proxy"
SPAWNED = "rerun+http://127.0.0.1:9876/proxy"
"""Where a viewer started on this machine listens."""
