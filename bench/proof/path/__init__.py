"""The most instructions of any call on a processor."""
