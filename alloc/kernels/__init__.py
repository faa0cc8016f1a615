"""Parts of methods' programs: closed forms, the exact answer, the way to a demand."""
