"""The version of this package: in a file of its own, so that every module can name it without importing the whole."""

__version__ = "0.1.0"
