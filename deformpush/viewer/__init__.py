"""The recording: the only room that knows Rerun."""
