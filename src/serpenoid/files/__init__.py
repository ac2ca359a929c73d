"""Files: those of others read safely (bounded, validated TOML), our own written whole, finished work kept."""
