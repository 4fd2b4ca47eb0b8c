"""Other programs' files of recordings and of models, read and written."""
