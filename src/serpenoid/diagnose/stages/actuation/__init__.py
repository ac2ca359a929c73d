"""From command to reading: what servos do."""
