"""What points alone show: beats, midlines, films without a scale."""
