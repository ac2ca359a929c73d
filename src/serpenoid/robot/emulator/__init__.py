"""A chain of servos on a pseudo-terminal: Protocol 2.0, control table, motion, faults. For rehearsal and tests."""
