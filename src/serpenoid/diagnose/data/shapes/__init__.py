"""Joint angles as functions of time, and bodies of such angles."""
