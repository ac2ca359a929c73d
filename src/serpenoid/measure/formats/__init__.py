"""Files of trackers, motion capture and whatever program: each becomes tracks."""
