"""Studies behind claims in the documents: scripts whose output a document quotes."""
