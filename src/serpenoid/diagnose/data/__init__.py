"""From recordings to windows of motion: shapes, clocks, tracks, noise level."""
