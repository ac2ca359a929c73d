"""From reading to marker: zeros, play, lengths, clocks."""
