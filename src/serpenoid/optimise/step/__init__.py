"""One step's equations with exact derivatives, for every kind of shape."""
