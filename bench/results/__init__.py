"""What a record says: rows, columns, statistics, rankings, sizes. Reads records and measures nothing."""
