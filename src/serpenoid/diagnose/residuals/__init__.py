"""What is left: maps, patterns in words, the gain on what was not fitted."""
