"""Small random fleets, drawn as new users draw them, and an oracle that says whether their orders can be served."""
