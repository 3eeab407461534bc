"""Pictures, movies and pages of what a run has written. `skein draw` is command.py."""
