"""Text files, read within a bound and written whole; YAML as plain data with line numbers."""
