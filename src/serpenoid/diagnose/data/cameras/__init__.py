"""What cameras make of a body: the model of observation."""
