"""The analyses of two documents, done again: the GMRT paper's and the RT32's."""
