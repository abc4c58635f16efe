"""Files of properties: their model, how they are read, and whether a world has what they speak of."""
