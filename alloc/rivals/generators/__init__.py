"""One file, one generator of C; ``alloc.rivals`` says what it offers."""
