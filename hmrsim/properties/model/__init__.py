"""Files of properties: their models, the reader, and the check of their names against a world."""
