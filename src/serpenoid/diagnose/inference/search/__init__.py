"""Which effects explain the windows: candidates, full fits, names."""
