"""Command to shape: what happens in the servos. One effect per file."""
