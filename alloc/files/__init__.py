"""Files as such: text read within a bound and written whole, YAML as plain data with line numbers."""
