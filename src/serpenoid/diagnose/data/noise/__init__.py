"""What chance does to windows and paths, and what repeats share."""
