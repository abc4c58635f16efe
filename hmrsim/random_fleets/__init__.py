"""Small random fleets as new users draw them, and an oracle that decides whether their orders can be served."""
