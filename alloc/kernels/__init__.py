"""What the programs of methods are put together from: closed forms, the exact answer, the way to a demand."""
