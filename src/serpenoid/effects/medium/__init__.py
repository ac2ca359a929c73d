"""Shape to motion: what the floor or the water does. One effect per file."""
