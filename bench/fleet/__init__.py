"""Many machines: a cluster of Dask workers, and runs that their hosts make of themselves."""
