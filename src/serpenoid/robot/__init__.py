"""The real robot: joint table to ticks, checks before anything moves, playing over the bus, the log, an emulator."""
