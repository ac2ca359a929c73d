"""Motion to data: what cameras and clocks make of it. One effect per file."""
