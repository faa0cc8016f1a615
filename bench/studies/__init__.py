"""Studies behind claims in the documents: each is a script whose output a document quotes."""
