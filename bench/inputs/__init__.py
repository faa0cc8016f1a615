"""Files of users: demands, logs, and vehicle files of other projects, and files to start from."""
