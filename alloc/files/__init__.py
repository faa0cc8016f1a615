"""Text files, read within a bound and written whole; YAML as plain data or as typed keys; modules by name."""
